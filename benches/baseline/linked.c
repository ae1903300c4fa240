/* Linked bodies by RATTLE, by hand: a double pendulum, a chain of rods, a heavy top. Unit masses and gravity 1.
 *
 *   linked double_pendulum    rods of length 1, h = 0.005; it falls from the horizontal. One body is told: the lower one.
 *   linked chain              n rods of length 1/n, h = 0.2/n; the same. Bodies 1 … n are told.
 *   linked top                moments 1, 1, 0.4, weight 1, leaning by 30°, spin 12, h = 0.02. Its axis is told.
 *
 * Rows: the first guess of multipliers from the present state (`state`), or extrapolated from three steps (`past`). Nothing is
 * compensated, and no root is checked. The conversation is that of opponent.h. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define EPS 2.220446049250313e-16
#define INLINE static inline __attribute__((always_inline))

static double seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- double pendulum: rods a = q1, b = q2 − q1; multipliers move 1 by s a − t b, 2 by t b ---- */
static struct { double q[4], v[4], s[2][3]; } pair;

static void pair_start(long n) {
  (void)n;
  memset(&pair, 0, sizeof pair);
  pair.q[0] = 1, pair.q[2] = 2;
}

INLINE void pair_advance(long steps, int past) {
  const double h = 0.005;
  double x = pair.q[0], y = pair.q[1], X = pair.q[2], Y = pair.q[3], u = pair.v[0], v = pair.v[1], U = pair.v[2], V = pair.v[3];
  double s = pair.s[0][0], s1 = pair.s[0][1], s2 = pair.s[0][2], t = pair.s[1][0], t1 = pair.s[1][1], t2 = pair.s[1][2];
  for (long k = 0; k < steps; k++) {
    double ax = x, ay = y, bx = X - x, by = Y - y, next_s, next_t;
    if (past) {
      next_s = 3 * (s - s1) + s2, next_t = 3 * (t - t1) + t2;
      s2 = s1, s1 = s, t2 = t1, t1 = t;
    } else {
      double aa = ax * ax + ay * ay, ab = ax * bx + ay * by, bb = bx * bx + by * by, wx = U - u, wy = V - v;
      double r = ay - u * u - v * v, R = -wx * wx - wy * wy, over = 0.5 * h * h / (2 * aa * bb - ab * ab);
      next_s = (2 * bb * r + ab * R) * over, next_t = (aa * R + ab * r) * over;
    }
    s = next_s, t = next_t;
    double fx = x + h * u, fy = y + h * v - 0.5 * h * h, Fx = X + h * U, Fy = Y + h * V - 0.5 * h * h, cx, cy, dx, dy, g, G;
#define PLACE cx = fx + (s * ax - t * bx), cy = fy + (s * ay - t * by), dx = Fx + t * bx - cx, dy = Fy + t * by - cy, \
  g = cx * cx + cy * cy - 1, G = dx * dx + dy * dy - 1
    PLACE;
    double m = cx * ax + cy * ay, M = 2 * (dx * bx + dy * by), o = -(cx * bx + cy * by), O = -(dx * ax + dy * ay);
    double half = 0.5 / (m * M - o * O), last = INFINITY;
    for (int i = 0; i < 20; i++) {
      double r = fmax(fabs(g), fabs(G));
      s -= (M * g - o * G) * half, t -= (m * G - O * g) * half;
      PLACE;
      if (r <= 1e-15 || (last < 1 && r * r <= 1e-15 / 16 * last)) break;
      last = r;
    }
    double over_h = 1 / h;
    u += (s * ax - t * bx) * over_h, v += (s * ay - t * by) * over_h - h, U += t * bx * over_h, V += t * by * over_h - h;
    double cc = cx * cx + cy * cy, cd = cx * dx + cy * dy, dd = dx * dx + dy * dy;
    double r = -(cx * u + cy * v), R = -(dx * (U - u) + dy * (V - v)), over = 1 / (2 * cc * dd - cd * cd);
    double p = (2 * dd * r + cd * R) * over, P = (cc * R + cd * r) * over;
    u += p * cx - P * dx, v += p * cy - P * dy, U += P * dx, V += P * dy;
    x = cx, y = cy, X = cx + dx, Y = cy + dy;
  }
  double q[4] = {x, y, X, Y}, w[4] = {u, v, U, V}, all[2][3] = {{s, s1, s2}, {t, t1, t2}};
  memcpy(pair.q, q, sizeof q), memcpy(pair.v, w, sizeof w), memcpy(pair.s, all, sizeof all);
}
static void pair_state(long steps) { pair_advance(steps, 0); }
static void pair_past(long steps) { pair_advance(steps, 1); }

static double pair_energy(double *kinetic, double *worst) {
  double *q = pair.q, *v = pair.v, x = q[2] - q[0], y = q[3] - q[1];
  *kinetic = 0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
  *worst = fmax(fabs(q[0] * q[0] + q[1] * q[1] - 1), fabs(x * x + y * y - 1));
  return *kinetic + q[1] + q[3];
}
static void pair_tell(void) {
  printf("%.17g %.17g 0 %.17g %.17g 0\n", pair.q[2], pair.q[3], pair.v[2], pair.v[3]);
}

/* ---- chain: body 0 is pinned, rod i goes from body i to i + 1; matrices are eliminated from both ends at once ---- */
static long n;
static double l, h, *x, *y, *u, *v, *dx, *dy, *ex, *ey, *X, *Y, *fx, *fy, *s, *s1, *s2, *g, *low, *on, *up, *over, *right, *z, *scale;

/* Half of ∇g(e)·∇g(d) over 2, factored: over are the reciprocals of the pivots. */
static void factor(const double *restrict ax, const double *restrict ay) {
  for (long i = 0; i < n; i++) on[i] = (i ? 2 : 1) * (ax[i] * dx[i] + ay[i] * dy[i]);
  for (long i = 1; i < n; i++) {
    low[i] = -(ax[i] * dx[i - 1] + ay[i] * dy[i - 1]);
    up[i - 1] = -(ax[i - 1] * dx[i] + ay[i - 1] * dy[i]);
  }
  long a = 0, b = n - 1;
  over[a] = 1 / on[a], over[b] = 1 / on[b];
  for (; b - a > 2; ) {
    a++, b--;
    over[a] = 1 / (on[a] - low[a] * up[a - 1] * over[a - 1]);
    over[b] = 1 / (on[b] - up[b] * low[b + 1] * over[b + 1]);
  }
  if (b - a == 2) {
    a++;
    over[a] = 1 / (on[a] - low[a] * up[a - 1] * over[a - 1] - up[a] * low[a + 1] * over[a + 1]);
  } else {
    over[b] = 1 / (on[b] - low[b] * up[a] * over[a] - (b + 1 < n ? up[b] * low[b + 1] * over[b + 1] : 0));
  }
}

static void solve(const double *restrict r) {
  long a = 0, b = n - 1, m;
  z[a] = r[a], z[b] = r[b];
  for (; b - a > 2; ) {
    a++, b--;
    z[a] = r[a] - low[a] * over[a - 1] * z[a - 1];
    z[b] = r[b] - up[b] * over[b + 1] * z[b + 1];
  }
  m = a + 1;
  if (b - a == 2) {
    z[m] = (r[m] - low[m] * over[a] * z[a] - up[m] * over[b] * z[b]) * over[m];
  } else {
    z[m] = (r[m] - low[m] * over[a] * z[a] - (m + 1 < n ? up[m] * over[m + 1] * z[m + 1] : 0)) * over[m];
    b = m + 1;
  }
  for (; a >= 0 || b < n; a--, b++) {
    if (a >= 0) z[a] = (z[a] - up[a] * z[a + 1]) * over[a];
    if (b < n) z[b] = (z[b] - low[b] * z[b - 1]) * over[b];
  }
}

static void rods(const double *restrict px, const double *restrict py, double *restrict a, double *restrict b) {
  for (long i = 0; i < n; i++) a[i] = px[i + 1] - px[i], b[i] = py[i + 1] - py[i];
}

/* to = from + c (what multipliers w do to body i + 1) + d */
INLINE void add(double *to, const double *from, double c, const double *w, const double *rod, double d) {
#pragma GCC ivdep /* `to` may be `from` */
  for (long i = 0; i < n - 1; i++) to[i + 1] = from[i + 1] + (c * (w[i] * rod[i] - w[i + 1] * rod[i + 1]) + d);
  to[n] = from[n] + (c * w[n - 1] * rod[n - 1] + d);
}

static double residual(void) {
  double worst = 0;
  rods(X, Y, ex, ey);
  for (long i = 0; i < n; i++) {
    g[i] = ex[i] * ex[i] + ey[i] * ey[i] - l * l;
    double r = fabs(g[i]) * scale[i];
    worst = r > worst ? r : worst;
  }
  return worst;
}

static void chain_start(long links) {
  double **all[] = {&x, &y, &u, &v, &dx, &dy, &ex, &ey, &X, &Y, &fx, &fy, &s, &s1, &s2, &g, &low, &on, &up, &over, &right, &z, &scale};
  for (unsigned i = 0; i < sizeof all / sizeof *all; i++) {
    size_t bytes = ((size_t)(links + 8) * 8 + 63) / 64 * 64;
    free(*all[i]);
    *all[i] = memset(aligned_alloc(64, bytes), 0, bytes);
  }
  n = links, l = 1.0 / (double)n, h = 0.2 * l;
  for (long i = 0; i <= n; i++) x[i] = (double)i * l;
  rods(x, y, dx, dy);
  factor(dx, dy);
}

INLINE void chain_advance(long steps, int past) {
  for (long k = 0; k < steps; k++) {
    for (long i = 0; i < n; i++) {
      double a = u[i + 1] - u[i], b = v[i + 1] - v[i];
      right[i] = -0.5 * h * h * (a * a + b * b);
    }
    if (past) {
      for (long i = 0; i < n; i++) {
        double next = 3 * (s[i] - s1[i]) + s2[i];
        s2[i] = s1[i], s1[i] = s[i], s[i] = next;
      }
    } else {
      right[0] += 0.5 * h * h * dy[0];
      solve(right);
      memcpy(s, z, (size_t)n * 8);
    }
    for (long i = 1; i <= n; i++) fx[i] = x[i] + h * u[i], fy[i] = y[i] + (h * v[i] - 0.5 * h * h);
    add(X, fx, 1, s, dx, 0), add(Y, fy, 1, s, dy, 0);
    for (long i = 0; i < n; i++) {
      double size = fmax(fmax(fabs(X[i]), fabs(Y[i])), fmax(fabs(X[i + 1]), fabs(Y[i + 1])));
      scale[i] = 1 / (EPS * size * 2.8284271247461903 * l);
    }
    double last = INFINITY, r = residual();
    factor(ex, ey);
    for (int i = 0; i < 40; i++) {
      for (long j = 0; j < n; j++) right[j] = -0.5 * g[j];
      solve(right);
      for (long j = 0; j < n; j++) s[j] += z[j];
      add(X, fx, 1, s, dx, 0), add(Y, fy, 1, s, dy, 0);
      if (r <= 1 || (r <= 0.25 * last && r * r <= last / 16)) break;
      last = r, r = residual();
      if (r > 0.25 * last) break; /* rounding of g */
    }
    add(u, u, 1 / h, s, dx, 0), add(v, v, 1 / h, s, dy, -h);
    memcpy(x + 1, X + 1, (size_t)n * 8), memcpy(y + 1, Y + 1, (size_t)n * 8);
    rods(x, y, dx, dy);
    factor(dx, dy);
    for (long i = 0; i < n; i++) right[i] = -(dx[i] * (u[i + 1] - u[i]) + dy[i] * (v[i + 1] - v[i]));
    solve(right);
    add(u, u, 1, z, dx, 0), add(v, v, 1, z, dy, 0);
  }
}
static void chain_state(long steps) { chain_advance(steps, 0); }
static void chain_past(long steps) { chain_advance(steps, 1); }

static double chain_energy(double *kinetic, double *worst) {
  double potential = 0;
  *kinetic = *worst = 0;
  for (long i = 0; i < n; i++) {
    double a = x[i + 1] - x[i], b = y[i + 1] - y[i];
    *kinetic += 0.5 * (u[i + 1] * u[i + 1] + v[i + 1] * v[i + 1]), potential += y[i + 1];
    *worst = fmax(*worst, fabs(a * a + b * b - l * l));
  }
  return *kinetic + potential;
}
static void chain_tell(void) {
  for (long i = 1; i <= n; i++) printf("%.17g %.17g 0 %.17g %.17g 0\n", x[i], y[i], u[i], v[i]);
}

/* ---- heavy top: Q by rows, m in the body's frame; e₀ J e + e × J e = h/2 m by Newton's method with the adjugate ---- */
static const double J[3] = {1, 1, 0.4};
static struct { double Q[9], m[3], e[3][3]; } top;

static void top_start(long number) {
  (void)number;
  double c = sqrt(3) / 2, Q[9] = {1, 0, 0, 0, c, -0.5, 0, 0.5, c};
  memset(&top, 0, sizeof top);
  memcpy(top.Q, Q, sizeof Q);
  top.m[2] = 4.8;
  for (int k = 0; k < 3; k++) top.e[0][k] = top.e[1][k] = top.e[2][k] = 0.01 * top.m[k] / J[k];
}

INLINE void top_advance(long steps, int past) {
  const double step = 0.02;
  double Q[9], m[3], e[3], e1[3], e2[3];
  memcpy(Q, top.Q, sizeof Q), memcpy(m, top.m, sizeof m);
  memcpy(e, top.e[0], sizeof e), memcpy(e1, top.e[1], sizeof e1), memcpy(e2, top.e[2], sizeof e2);
  for (long k = 0; k < steps; k++) {
    m[0] += 0.5 * step * Q[7], m[1] -= 0.5 * step * Q[6];
    double w[3], c, last = INFINITY;
    for (int i = 0; i < 3; i++) {
      w[i] = 0.5 * step * m[i];
      double next = past ? 3 * (e[i] - e1[i]) + e2[i] : w[i] / J[i];
      e2[i] = e1[i], e1[i] = e[i], e[i] = next;
    }
    for (int i = 0; i < 20; i++) {
      c = sqrt(1 - (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]));
      double j[3] = {J[0] * e[0], J[1] * e[1], J[2] * e[2]}, o = 1 / c;
      double r[3] = {j[0] * c + e[1] * j[2] - e[2] * j[1] - w[0], j[1] * c + e[2] * j[0] - e[0] * j[2] - w[1],
                     j[2] * c + e[0] * j[1] - e[1] * j[0] - w[2]};
      double D[3][3] = {{J[0] * c - j[0] * e[0] * o, -j[0] * e[1] * o - e[2] * J[1] + j[2], -j[0] * e[2] * o + e[1] * J[2] - j[1]},
                        {-j[1] * e[0] * o + e[2] * J[0] - j[2], J[1] * c - j[1] * e[1] * o, -j[1] * e[2] * o - e[0] * J[2] + j[0]},
                        {-j[2] * e[0] * o - e[1] * J[0] + j[1], -j[2] * e[1] * o + e[0] * J[1] - j[0], J[2] * c - j[2] * e[2] * o}};
      double A[3][3], d[3], size = 0, length = 0;
      for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
          int p = (b + 1) % 3, q = (b + 2) % 3, f = (a + 1) % 3, t = (a + 2) % 3;
          A[a][b] = D[p][f] * D[q][t] - D[p][t] * D[q][f];
        }
      double det = 1 / (D[0][0] * A[0][0] + D[1][0] * A[0][1] + D[2][0] * A[0][2]);
      for (int a = 0; a < 3; a++) {
        d[a] = (A[a][0] * r[0] + A[a][1] * r[1] + A[a][2] * r[2]) * det;
        e[a] -= d[a], size = fmax(size, fabs(d[a])), length = fmax(length, fabs(e[a]));
      }
      if (size <= EPS * length || (last < 1 && size * size * size <= EPS / 16 * length * last * last)) break;
      last = size;
    }
    c = sqrt(1 - (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]));
    double a = e[0], b = e[1], d = e[2], f = 4 / step;
    m[0] -= f * (b * J[2] * d - d * J[1] * b), m[1] -= f * (d * J[0] * a - a * J[2] * d), m[2] -= f * (a * J[1] * b - b * J[0] * a);
    double R[9] = {-2 * (b * b + d * d), 2 * (a * b - c * d), 2 * (a * d + c * b), 2 * (a * b + c * d), -2 * (a * a + d * d),
                   2 * (b * d - c * a),  2 * (a * d - c * b), 2 * (b * d + c * a), -2 * (a * a + b * b)};
    for (int i = 0; i < 3; i++) {
      double p = Q[3 * i], q = Q[3 * i + 1], r = Q[3 * i + 2];
      for (int t = 0; t < 3; t++) Q[3 * i + t] += p * R[t] + q * R[3 + t] + r * R[6 + t];
    }
    m[0] += 0.5 * step * Q[7], m[1] -= 0.5 * step * Q[6];
  }
  memcpy(top.Q, Q, sizeof Q), memcpy(top.m, m, sizeof m);
  memcpy(top.e[0], e, sizeof e), memcpy(top.e[1], e1, sizeof e1), memcpy(top.e[2], e2, sizeof e2);
}
static void top_state(long steps) { top_advance(steps, 0); }
static void top_past(long steps) { top_advance(steps, 1); }

static double top_energy(double *kinetic, double *worst) {
  const double *Q = top.Q;
  *kinetic = *worst = 0;
  for (int i = 0; i < 3; i++) {
    *kinetic += 0.5 * top.m[i] * top.m[i] / J[i];
    for (int j = 0; j < 3; j++) *worst = fmax(*worst, fabs(Q[i] * Q[j] + Q[3 + i] * Q[3 + j] + Q[6 + i] * Q[6 + j] - (i == j)));
  }
  return *kinetic + Q[8];
}
static void top_tell(void) {
  printf("%.17g %.17g %.17g %.17g %.17g %.17g\n", top.Q[2], top.Q[5], top.Q[8], top.m[0], top.m[1], top.m[2]);
}

static const struct task {
  const char *name;
  void (*start)(long), (*state)(long), (*past)(long), (*tell)(void);
  double (*energy)(double *, double *);
} tasks[] = {{"double_pendulum", pair_start, pair_state, pair_past, pair_tell, pair_energy},
             {"chain", chain_start, chain_state, chain_past, chain_tell, chain_energy},
             {"top", top_start, top_state, top_past, top_tell, top_energy}};

int main(int count, char **arguments) {
  const struct task *task = NULL;
  for (int i = 0; count == 2 && i < 3; i++)
    if (!strcmp(tasks[i].name, arguments[1])) task = &tasks[i];
  if (!task) return 1;
  char line[256], word[16], name[64];
  long number, steps;
  while (fgets(line, sizeof line, stdin)) {
    if (!strncmp(line, "rows", 4)) {
      printf("state past\n");
    } else if (sscanf(line, "%15s %63s %ld %ld", word, name, &number, &steps) == 4) {
      void (*advance)(long) = strcmp(name, "past") ? task->state : task->past;
      task->start(number);
      if (!strcmp(word, "time")) {
        double before = seconds();
        advance(steps);
        printf("%.9e\n", seconds() - before);
      } else {
        double kinetic, worst, all = 0, off = 0, deviation = 0, first = task->energy(&kinetic, &worst);
        for (long k = 0; k < steps; k++) {
          advance(1);
          deviation = fmax(deviation, fabs(task->energy(&kinetic, &worst) - first));
          all += kinetic, off = worst <= off ? off : worst < 1 ? worst : INFINITY;
        }
        printf("%.3e %.6e %.6e 0 0\n", off, deviation, all / (double)steps);
        task->tell();
      }
    } else {
      return 1;
    }
    fflush(stdout);
  }
  return 0;
}
