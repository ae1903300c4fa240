/* A gas on the lemniscate surface: every pair of particles has the Ricker potential
 *
 *   U(r) = D/2 (1 − 3ρ²) exp(3/2 (1 − ρ²)),  ρ = r/R,  D = 1/2,  R = 1/6
 *
 * RATTLE, one number at a time and in vector registers. The start is read from the file named: the step size, then a
 * position per line; all are at rest. Requests are those of opponent.h, with the number of particles for n. */
#include "opponent.h"
#include "vector.h"

#define K 36.0             /* 1/R² */
#define STRENGTH (4.5 * 0.5 * K) /* force = STRENGTH (1 − Kr²) exp(3/2 (1 − Kr²)) (qᵢ − qⱼ) */

struct gas {
  long n, padded;
  double h;
  double *q[3], *p[3], *f[3], *m[3], *s[3]; /* m = ∇g/2; s as in scalar.c */
  double values;
};

static double *start;
static double start_h;
static long start_n;

static struct gas make_gas(void) {
  struct gas e = {.n = start_n, .padded = (start_n + 2 * WIDTH - 1) / WIDTH * WIDTH, .h = start_h};
  double **columns[5] = {e.q, e.p, e.f, e.m, e.s};
  for (int a = 0; a < 5; a++)
    for (int c = 0; c < 3; c++) columns[a][c] = column(e.padded);
  for (long i = 0; i < e.padded; i++)
    for (int c = 0; c < 3; c++) e.q[c][i] = i < e.n ? start[3 * i + c] : (c == 0 ? 1e3 : 0);
  return e;
}

static void drop_gas(struct gas *e) {
  double **columns[5] = {e->q, e->p, e->f, e->m, e->s};
  for (int a = 0; a < 5; a++)
    for (int c = 0; c < 3; c++) free(columns[a][c]);
}

static void forces_scalar(struct gas *e) {
  for (int c = 0; c < 3; c++) memset(e->f[c], 0, (size_t)e->padded * sizeof(double));
  for (long i = 0; i < e->n; i++) {
    double x = e->q[0][i], y = e->q[1][i], z = e->q[2][i], fx = 0, fy = 0, fz = 0;
    for (long j = i + 1; j < e->n; j++) {
      double dx = x - e->q[0][j], dy = y - e->q[1][j], dz = z - e->q[2][j];
      double a = 1 - K * (dx * dx + dy * dy + dz * dz);
      double size = STRENGTH * a * exp(1.5 * a);
      fx += size * dx, fy += size * dy, fz += size * dz;
      e->f[0][j] -= size * dx, e->f[1][j] -= size * dy, e->f[2][j] -= size * dz;
    }
    e->f[0][i] += fx, e->f[1][i] += fy, e->f[2][i] += fz;
  }
}

/* exp for arguments up to 700; far below −700 it is tiny instead of smaller still. */
INLINE vec exponential(vec x) {
  const double c[] = {1, 1, 1. / 2, 1. / 6, 1. / 24, 1. / 120, 1. / 720, 1. / 5040, 1. / 40320, 1. / 362880,
                      1. / 3628800, 1. / 39916800, 1. / 479001600};
  vec magic = SPLAT(0x1.8p52);
  x = MAX(x, SPLAT(-700));
  vec shifted = FMA(x, SPLAT(0x1.71547652b82fep0), magic), k = shifted - magic;
  vec r = FNMA(k, SPLAT(0x1.62e42fefa39efp-1), x);
  r = FNMA(k, SPLAT(0x1.abc9e3b39803fp-56), r);
  vec r2 = r * r, r4 = r2 * r2;
#define PAIR(i) FMA(SPLAT(c[i + 1]), r, SPLAT(c[i]))
  vec low = FMA(PAIR(2), r2, PAIR(0)), mid = FMA(PAIR(6), r2, PAIR(4)), high = FMA(PAIR(10), r2, PAIR(8));
  high = FMA(SPLAT(c[12]), r4, high);
  return TIMES_POWER_OF_TWO(FMA(FMA(high, r4, mid), r4, low), shifted);
}

/* STRENGTH in the lanes after this one, 0 up to it. */
INLINE vec later(long lane) {
  static const double weights[2 * WIDTH] = {
      [WIDTH ... 2 * WIDTH - 1] = STRENGTH,
  };
  vec x;
  memcpy(&x, weights + WIDTH - 1 - lane, sizeof x);
  return x;
}

/* Pairs i < j, a register of j at a time; pairs of the first register that are not such get weight 0. (Two or four i at
 * a time are no faster: the exponential is what takes the time.) */
static void forces_lanes(struct gas *e) {
  for (int c = 0; c < 3; c++) memset(e->f[c], 0, (size_t)e->padded * sizeof(double));
  for (long i = 0; i < e->n; i++) {
    const vec q[3] = {SPLAT(e->q[0][i]), SPLAT(e->q[1][i]), SPLAT(e->q[2][i])};
    vec f[3] = {SPLAT(0), SPLAT(0), SPLAT(0)}, keep = later(i % WIDTH), d[3];
    for (long j = i / WIDTH * WIDTH; j < e->n; j += WIDTH) {
      for (int c = 0; c < 3; c++) d[c] = q[c] - LOAD(e->q[c] + j);
      vec a = FNMA(SPLAT(K), FMA(d[0], d[0], FMA(d[1], d[1], d[2] * d[2])), SPLAT(1));
      vec size = keep * a * exponential(SPLAT(1.5) * a);
      keep = SPLAT(STRENGTH);
      for (int c = 0; c < 3; c++) {
        f[c] = FMA(size, d[c], f[c]);
        STORE(e->f[c] + j, FNMA(size, d[c], LOAD(e->f[c] + j)));
      }
    }
    for (int c = 0; c < 3; c++) e->f[c][i] += TOTAL(f[c]);
  }
}

/* First half of a step of one particle, or of one register of them. */
#define DRIFT(T, GET, PUT, NUMBER, OFF_THE_SURFACE, WIDE)                                                    \
  for (long i = 0; i < e->n; i += WIDE) {                                                                    \
    T n[3], X[3], p[3], q[3], m[3], g, half = NUMBER(0.5 * e->h), h = NUMBER(e->h);                          \
    T s0 = GET(e->s[0] + i), s1 = GET(e->s[1] + i), s = NUMBER(3) * (s0 - s1) + GET(e->s[2] + i);            \
    for (int c = 0; c < 3; c++) {                                                                            \
      n[c] = GET(e->m[c] + i), p[c] = GET(e->p[c] + i) + half * GET(e->f[c] + i);                            \
      X[c] = GET(e->q[c] + i) + h * p[c];                                                                    \
    }                                                                                                        \
    for (int k = 0;; k++) {                                                                                  \
      for (int c = 0; c < 3; c++) q[c] = X[c] - s * n[c];                                                    \
      T y2 = q[1] * q[1], t = q[0] * q[0] + y2, f = t * t - (q[0] * q[0] - y2);                              \
      g = f * f + (q[2] * q[2] - NUMBER(R2));                                                                \
      m[0] = q[0] * f * (NUMBER(4) * t - NUMBER(2)), m[1] = q[1] * f * (NUMBER(4) * t + NUMBER(2)), m[2] = q[2]; \
      e->values += WIDE;                                                                                     \
      if (!OFF_THE_SURFACE(g) || k == 50) break;                                                             \
      s = s + NUMBER(0.5) * g / (m[0] * n[0] + m[1] * n[1] + m[2] * n[2]);                                   \
    }                                                                                                        \
    PUT(e->s[2] + i, s1);                                                                                    \
    PUT(e->s[1] + i, s0);                                                                                    \
    PUT(e->s[0] + i, s);                                                                                     \
    for (int c = 0; c < 3; c++) {                                                                            \
      PUT(e->q[c] + i, q[c]);                                                                                \
      PUT(e->p[c] + i, p[c] - s * n[c] * NUMBER(1 / e->h));                                                  \
      PUT(e->m[c] + i, m[c]);                                                                                \
    }                                                                                                        \
  }

/* Second half. */
#define SETTLE(T, GET, PUT, NUMBER, WIDE)                                                   \
  for (long i = 0; i < e->n; i += WIDE) {                                                   \
    T n[3], p[3], half = NUMBER(0.5 * e->h);                                                \
    for (int c = 0; c < 3; c++)                                                             \
      n[c] = GET(e->m[c] + i), p[c] = GET(e->p[c] + i) + half * GET(e->f[c] + i);           \
    T mu = (n[0] * p[0] + n[1] * p[1] + n[2] * p[2]) / (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]); \
    for (int c = 0; c < 3; c++) PUT(e->p[c] + i, p[c] - mu * n[c]);                         \
  }

#define GET_ONE(p) (*(p))
#define PUT_ONE(p, x) (*(p) = (x))
#define ONE(x) (x)
#define OFF_ONE(g) (!(fabs(g) <= TOLERANCE))
#define OFF_LANES(g) ANY(OFF(g))

static void normals(struct gas *e) {
  for (long i = 0; i < e->padded; i++) {
    double x = e->q[0][i], y = e->q[1][i], t = x * x + y * y, f = t * t - (x * x - y * y);
    e->m[0][i] = x * f * (4 * t - 2), e->m[1][i] = y * f * (4 * t + 2), e->m[2][i] = e->q[2][i];
  }
}

static void advance_scalar(struct gas *e, long steps) {
  normals(e);
  forces_scalar(e);
  for (long k = 0; k < steps; k++) {
    DRIFT(double, GET_ONE, PUT_ONE, ONE, OFF_ONE, 1)
    forces_scalar(e);
    SETTLE(double, GET_ONE, PUT_ONE, ONE, 1)
  }
}

/* Particles that only fill the last register stay at the first one's place, but far from it in the pair forces. */
static void advance_lanes(struct gas *e, long steps) {
  normals(e);
  forces_lanes(e);
  for (long k = 0; k < steps; k++) {
    for (long i = e->n; i < e->padded; i++)
      for (int c = 0; c < 3; c++) {
        e->q[c][i] = e->q[c][0], e->m[c][i] = e->m[c][0], e->p[c][i] = e->p[c][0], e->f[c][i] = e->f[c][0];
        for (int a = 0; a < 3; a++) e->s[a][i] = e->s[a][0];
      }
    DRIFT(vec, LOAD, STORE, SPLAT, OFF_LANES, WIDTH)
    for (long i = e->n; i < e->padded; i++) e->q[0][i] = 1e3;
    forces_lanes(e);
    SETTLE(vec, LOAD, STORE, SPLAT, WIDTH)
  }
}

static double energy(const struct gas *e, double *kinetic) {
  double potential = 0;
  *kinetic = 0;
  for (long i = 0; i < e->n; i++) {
    for (int c = 0; c < 3; c++) *kinetic += 0.5 * e->p[c][i] * e->p[c][i];
    for (long j = 0; j < i; j++) {
      double s = 0;
      for (int c = 0; c < 3; c++) s += (e->q[c][i] - e->q[c][j]) * (e->q[c][i] - e->q[c][j]);
      potential += 0.25 * (1 - 3 * K * s) * exp(1.5 * (1 - K * s));
    }
  }
  return *kinetic + potential;
}

int main(int count, char **arguments) {
  FILE *file = count == 2 ? fopen(arguments[1], "r") : NULL;
  if (!file || fscanf(file, "%lf", &start_h) != 1) return 1;
  start = malloc(3 * 100000 * sizeof(double));
  for (long i = 0; i < 300000 && fscanf(file, "%lf", start + i) == 1; i++) start_n = (i + 1) / 3;
  fclose(file);

  char line[256], word[16], name[64];
  long n, steps;
  while (fgets(line, sizeof line, stdin)) {
    if (!strncmp(line, "rows", 4)) {
      printf("scalar lanes\n");
    } else if (sscanf(line, "%15s %63s %ld %ld", word, name, &n, &steps) == 4 && n == start_n) {
      void (*advance)(struct gas *, long) = strcmp(name, "lanes") ? advance_scalar : advance_lanes;
      struct gas e = make_gas();
      if (!strcmp(word, "time")) {
        double before = seconds();
        advance(&e, steps);
        printf("%.9e\n", seconds() - before);
      } else {
        double kinetic, all = 0, deviation = 0, worst = 0, first = energy(&e, &kinetic);
        for (long k = 0; k < steps; k++) {
          advance(&e, 1);
          deviation = fmax(deviation, fabs(energy(&e, &kinetic) - first));
          all += kinetic;
          for (long i = 0; i < n; i++) {
            double x = e.q[0][i], y = e.q[1][i], z = e.q[2][i], t = x * x + y * y, f = t * t - (x * x - y * y);
            double g = fabs(f * f + z * z - R2);
            worst = g <= worst ? worst : g < 1 ? g : INFINITY;
          }
        }
        double evaluations = e.values / ((double)n * (double)steps);
        printf("%.3e %.6e %.6e %.4f %.4f\n", worst, deviation, all / (double)steps, evaluations, evaluations);
        for (long i = 0; i < n; i++)
          printf("%.17g %.17g %.17g %.17g %.17g %.17g\n", e.q[0][i], e.q[1][i], e.q[2][i], e.p[0][i], e.p[1][i],
                 e.p[2][i]);
      }
      drop_gas(&e);
    } else {
      return 1;
    }
    fflush(stdout);
  }
  return 0;
}
