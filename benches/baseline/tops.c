/* Many heavy tops side by side by RATTLE, by hand, in plain loops for the compiler: moments 1, 1, 0.4, weight 1, leaning by
 * 30°, h = 0.02. Top i of n spins with the momentum 2.4 + 4.8 i/n. Its axis is told.
 *
 * The equation of a step is solved for Rodrigues' vector x = v + u: quadratic, without a root. What u has beyond its second
 * order is extrapolated from three steps, one matrix serves each step, and corrections end once the next one would be below a
 * sixteenth of a rounding. Nothing is compensated, no root is checked, and attitudes are not straightened. The conversation is
 * that of opponent.h. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define L 64
#define EACH for (int i = 0; i < L; i++)
static const double h = 0.02, J = 0.4, A = 0.4 - 1; /* a = (A, −A, 0) of moments 1, 1, J */

static double seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Q by rows, h m ahead by half a kick, and rests: of the step to come, and the last two. */
typedef struct __attribute__((aligned(64))) {
  double Q[9][L], w[3][L], e[3][3][L];
} block;

static void step(block *restrict p) {
  static double x[L], y[L], z[L], r[3][L], M[9][L] __attribute__((aligned(64)));
#define AHEAD double a = 0.5 * p->w[0][i], b = 0.5 * p->w[1][i], c = 0.5 / J * p->w[2][i], n0 = a * a + b * b + c * c, \
  ga = n0 * a - A * b * c, gb = n0 * b + A * c * a, gc = n0 * c
#define PLACE double ua = ga + ra, ub = gb + rb, uc = gc + rc, X = a + ua, Y = b + ub, Z = c + uc, n = X * X + Y * Y + Z * Z
#define RESIDUAL double ea = ua + A * Y * Z - n * a, eb = ub - A * Z * X - n * b, ec = uc - n * c
  EACH {
    AHEAD;
    double ra = p->e[0][0][i], rb = p->e[0][1][i], rc = p->e[0][2][i];
    {
      PLACE;
      RESIDUAL;
      double s = -2 * a, t = -2 * b, q = -2 * c;
      double m0 = 1 + s * X, m1 = s * Y + A * Z, m2 = s * Z + A * Y, m3 = t * X - A * Z, m4 = 1 + t * Y, m5 = t * Z - A * X,
             m6 = q * X, m7 = q * Y, m8 = 1 + q * Z;
      double i0 = m4 * m8 - m5 * m7, i3 = m5 * m6 - m3 * m8, i6 = m3 * m7 - m4 * m6, over = 1 / (m0 * i0 + m1 * i3 + m2 * i6);
      M[0][i] = i0 * over, M[3][i] = i3 * over, M[6][i] = i6 * over;
      M[1][i] = (m2 * m7 - m1 * m8) * over, M[4][i] = (m0 * m8 - m2 * m6) * over, M[7][i] = (m1 * m6 - m0 * m7) * over;
      M[2][i] = (m1 * m5 - m2 * m4) * over, M[5][i] = (m2 * m3 - m0 * m5) * over, M[8][i] = (m0 * m4 - m1 * m3) * over;
      r[0][i] = ra - (M[0][i] * ea + M[1][i] * eb + M[2][i] * ec), r[1][i] = rb - (M[3][i] * ea + M[4][i] * eb + M[5][i] * ec);
      r[2][i] = rc - (M[6][i] * ea + M[7][i] * eb + M[8][i] * ec);
    }
  }
  for (int k = 0; k < 20; k++) {
    double worst = 0;
    EACH {
      AHEAD;
      double ra = r[0][i], rb = r[1][i], rc = r[2][i], sa = p->e[0][0][i] - ra, sb = p->e[0][1][i] - rb, sc = p->e[0][2][i] - rc;
      PLACE;
      RESIDUAL;
      double da = M[0][i] * ea + M[1][i] * eb + M[2][i] * ec, db = M[3][i] * ea + M[4][i] * eb + M[5][i] * ec;
      double dc = M[6][i] * ea + M[7][i] * eb + M[8][i] * ec, next = 16 * (da * da + db * db + dc * dc) * (sa * sa + sb * sb + sc * sc);
      r[0][i] = ra - da, r[1][i] = rb - db, r[2][i] = rc - dc, x[i] = X - da, y[i] = Y - db, z[i] = Z - dc;
      double off = next - 1.9e-34 * n;
      worst = worst > off ? worst : off;
    }
    if (worst <= 0) break;
  }
  EACH {
    double X = x[i], Y = y[i], Z = z[i], s = 2 / (1 + X * X + Y * Y + Z * Z), a = s * X, b = s * Y, c = s * Z;
    double R0 = -(b * Y + c * Z), R1 = a * Y - c, R2 = a * Z + b, R3 = a * Y + c, R4 = -(a * X + c * Z), R5 = b * Z - a,
           R6 = a * Z - b, R7 = b * Z + a, R8 = -(a * X + b * Y), q[9];
    for (int j = 0; j < 3; j++) {
      double k = p->Q[3 * j][i], l = p->Q[3 * j + 1][i], m = p->Q[3 * j + 2][i];
      q[3 * j] = k + (k * R0 + l * R3 + m * R6), q[3 * j + 1] = l + (k * R1 + l * R4 + m * R7), q[3 * j + 2] = m + (k * R2 + l * R5 + m * R8);
    }
    for (int j = 0; j < 9; j++) p->Q[j][i] = q[j];
    p->w[0][i] += h * h * q[7] - 2 * A * (b * Z), p->w[1][i] += 2 * A * (c * X) - h * h * q[6];
    for (int j = 0; j < 3; j++) {
      double new = r[j][i], last = p->e[1][j][i];
      p->e[0][j][i] = 3 * (new - last) + p->e[2][j][i], p->e[2][j][i] = last, p->e[1][j][i] = new;
    }
  }
}

static block *blocks;
static long number;

static void start(long n) {
  size_t count = (size_t)((n + L - 1) / L);
  free(blocks);
  blocks = aligned_alloc(64, count * sizeof *blocks), number = n;
  memset(blocks, 0, count * sizeof *blocks);
  double c = sqrt(3) / 2, Q[9] = {1, 0, 0, 0, c, -0.5, 0, 0.5, c};
  for (size_t j = 0; j < count * L; j++) {
    block *p = &blocks[j / L];
    double w = h * (2.4 + 4.8 * (double)(j < (size_t)n ? j : 0) / (double)n), v = 0.5 / J * w, x = v;
    for (int k = 0; k < 9; k++) p->Q[k][j % L] = Q[k];
    for (int k = 0; k < 99; k++) x = (1 + x * x) * v;
    p->w[0][j % L] = 0.5 * h * h * Q[7], p->w[1][j % L] = -0.5 * h * h * Q[6], p->w[2][j % L] = w;
    for (int k = 0; k < 3; k++) p->e[k][2][j % L] = x - v - v * v * v;
  }
}

static void advance(long steps) {
  for (long b = 0; b < (number + L - 1) / L; b++)
    for (long k = 0; k < steps; k++) step(&blocks[b]);
}

/* Momenta with half a kick taken back. */
static void momenta(const block *p, long i, double *m) {
  m[0] = p->w[0][i] / h - 0.5 * h * p->Q[7][i], m[1] = p->w[1][i] / h + 0.5 * h * p->Q[6][i], m[2] = p->w[2][i] / h;
}

/* The mean over all. */
static double energy(double *kinetic, double *worst) {
  double sum = 0, m[3];
  *kinetic = *worst = 0;
  for (long j = 0; j < number; j++) {
    const block *p = &blocks[j / L];
    long l = j % L;
    momenta(p, l, m);
    double k = 0.5 * (m[0] * m[0] + m[1] * m[1] + m[2] * m[2] / J);
    *kinetic += k / (double)number, sum += (k + p->Q[8][l]) / (double)number;
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) *worst = fmax(*worst, fabs(p->Q[a][l] * p->Q[b][l] + p->Q[3 + a][l] * p->Q[3 + b][l] + p->Q[6 + a][l] * p->Q[6 + b][l] - (a == b)));
  }
  return sum;
}

int main(void) {
  char line[256], word[16], name[64];
  long n, steps;
  while (fgets(line, sizeof line, stdin)) {
    if (!strncmp(line, "rows", 4)) {
      printf("past\n");
    } else if (sscanf(line, "%15s %63s %ld %ld", word, name, &n, &steps) == 4) {
      start(n);
      if (!strcmp(word, "time")) {
        double before = seconds();
        advance(steps);
        printf("%.9e\n", seconds() - before);
      } else {
        double kinetic, worst, all = 0, off = 0, deviation = 0, first = energy(&kinetic, &worst);
        for (long k = 0; k < steps; k++) {
          advance(1);
          deviation = fmax(deviation, fabs(energy(&kinetic, &worst) - first));
          all += kinetic, off = worst <= off ? off : worst < 1 ? worst : 1e300;
        }
        printf("%.3e %.6e %.6e 0 0\n", off, deviation, all / (double)steps);
        for (long j = 0; j < n; j++) {
          const block *p = &blocks[j / L];
          double m[3];
          momenta(p, j % L, m);
          printf("%.17g %.17g %.17g %.17g %.17g %.17g\n", p->Q[2][j % L], p->Q[5][j % L], p->Q[8][j % L], m[0], m[1], m[2]);
        }
      }
    } else {
      return 1;
    }
    fflush(stdout);
  }
  return 0;
}
