/* Many double pendulums side by side by RATTLE, by hand, in plain loops for the compiler: rods and masses 1, gravity 1,
 * h = 0.005. Both rods of pendulum i of n hang straight, 0.5 + 1.5 i/n from the vertical, at rest; the lower body is told.
 *
 * The first guess of multipliers is extrapolated from three steps, one matrix serves each step, and corrections end once the
 * last one is below 3e-12: the next would be 1e-4 of it. Nothing is compensated, and no root is checked. The conversation is
 * that of opponent.h. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define L 64
#define EACH for (int i = 0; i < L; i++)
static const double h = 0.005;

static double seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Rods a = q, b = Q − q; multipliers move the upper body by s a − t b, the lower by t b. */
typedef struct __attribute__((aligned(64))) {
  double x[L], y[L], X[L], Y[L], u[L], v[L], U[L], V[L], s[3][L], t[3][L];
} block;

static void step(block *restrict p) {
  static double fx[L], fy[L], FX[L], FY[L], a00[L], a01[L], a10[L], a11[L], s[L], t[L] __attribute__((aligned(64)));
#define RODS double ax = p->x[i], ay = p->y[i], bx = p->X[i] - ax, by = p->Y[i] - ay
#define PLACE double cx = fx[i] + (s[i] * ax - t[i] * bx), cy = fy[i] + (s[i] * ay - t[i] * by), \
  px = FX[i] + t[i] * bx, py = FY[i] + t[i] * by, dx = px - cx, dy = py - cy
#define RESIDUAL double g = cx * cx + cy * cy - 1, G = dx * dx + dy * dy - 1
  EACH {
    RODS;
    s[i] = 3 * (p->s[0][i] - p->s[1][i]) + p->s[2][i], t[i] = 3 * (p->t[0][i] - p->t[1][i]) + p->t[2][i];
    fx[i] = ax + h * p->u[i], fy[i] = ay + h * p->v[i] - 0.5 * h * h;
    FX[i] = p->X[i] + h * p->U[i], FY[i] = p->Y[i] + h * p->V[i] - 0.5 * h * h;
    PLACE;
    RESIDUAL;
    double m = cx * ax + cy * ay, M = 2 * (dx * bx + dy * by), o = -(cx * bx + cy * by), O = -(dx * ax + dy * ay);
    double half = 0.5 / (m * M - o * O);
    a00[i] = M * half, a01[i] = -o * half, a10[i] = -O * half, a11[i] = m * half;
    s[i] -= a00[i] * g + a01[i] * G, t[i] -= a10[i] * g + a11[i] * G;
  }
  for (int k = 0; k < 20; k++) {
    double worst = 0;
    EACH {
      RODS;
      PLACE;
      RESIDUAL;
      s[i] -= a00[i] * g + a01[i] * G, t[i] -= a10[i] * g + a11[i] * G;
      double r = fmax(fabs(g), fabs(G));
      worst = worst > r ? worst : r;
    }
    if (worst <= 3e-12) break;
  }
  EACH {
    RODS;
    PLACE;
    double u = p->u[i] + (s[i] * ax - t[i] * bx) / h, v = p->v[i] + (s[i] * ay - t[i] * by) / h - h;
    double U = p->U[i] + t[i] * bx / h, V = p->V[i] + t[i] * by / h - h;
    double cc = cx * cx + cy * cy, cd = cx * dx + cy * dy, dd = dx * dx + dy * dy;
    double r = -(cx * u + cy * v), R = -(dx * (U - u) + dy * (V - v)), over = 1 / (2 * cc * dd - cd * cd);
    double e = (2 * dd * r + cd * R) * over, E = (cc * R + cd * r) * over;
    p->u[i] = u + e * cx - E * dx, p->v[i] = v + e * cy - E * dy, p->U[i] = U + E * dx, p->V[i] = V + E * dy;
    p->x[i] = cx, p->y[i] = cy, p->X[i] = px, p->Y[i] = py;
    p->s[2][i] = p->s[1][i], p->s[1][i] = p->s[0][i], p->s[0][i] = s[i];
    p->t[2][i] = p->t[1][i], p->t[1][i] = p->t[0][i], p->t[0][i] = t[i];
  }
}

static block *blocks;
static long number;

static void start(long n) {
  size_t count = (size_t)((n + L - 1) / L);
  free(blocks);
  blocks = aligned_alloc(64, count * sizeof *blocks), number = n;
  memset(blocks, 0, count * sizeof *blocks);
  for (size_t j = 0; j < count * L; j++) {
    double angle = 0.5 + 1.5 * (double)(j < (size_t)n ? j : 0) / (double)n;
    block *p = &blocks[j / L];
    p->x[j % L] = sin(angle), p->y[j % L] = -cos(angle), p->X[j % L] = 2 * sin(angle), p->Y[j % L] = -2 * cos(angle);
  }
}

static void advance(long steps) {
  for (long b = 0; b < (number + L - 1) / L; b++)
    for (long k = 0; k < steps; k++) step(&blocks[b]);
}

/* The mean over all. */
static double energy(double *kinetic, double *worst) {
  double sum = 0;
  *kinetic = *worst = 0;
  for (long j = 0; j < number; j++) {
    const block *p = &blocks[j / L];
    long i = j % L;
    double dx = p->X[i] - p->x[i], dy = p->Y[i] - p->y[i];
    double k = 0.5 * (p->u[i] * p->u[i] + p->v[i] * p->v[i] + p->U[i] * p->U[i] + p->V[i] * p->V[i]);
    *kinetic += k / (double)number, sum += (k + p->y[i] + p->Y[i]) / (double)number;
    *worst = fmax(*worst, fmax(fabs(p->x[i] * p->x[i] + p->y[i] * p->y[i] - 1), fabs(dx * dx + dy * dy - 1)));
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
          printf("%.17g %.17g 0 %.17g %.17g 0\n", p->X[j % L], p->Y[j % L], p->U[j % L], p->V[j % L]);
        }
      }
    } else {
      return 1;
    }
    fflush(stdout);
  }
  return 0;
}
