/* Lobatto IIIA-IIIB of five stages on the lemniscate surface, as plain loops over blocks of trajectories. A block goes on until its
 * last trajectory rests; nothing is compensated, and no root is checked.
 *
 * Unknowns of a step are four places Q and four multipliers s; a pass evaluates g and m = ∇g/2 at all Q, forms the sums
 * n = q + h c v + h² A w with w = 2 s m + gravity, and corrects s by the linearised g(n) = 0 with the matrix of the first pass.
 * The first guess is the polynomial through w and s of the step before and of its end. */
#define H 0.025
#include "opponent.h"

#define MOST 32
#define EACH for (int i = 0; i < L; i++)
#define STAGES for (int k = 0; k < 4; k++)
#define AXES for (int d = 0; d < 3; d++)

static const double NODE[5] = {0, 0.17267316464601143, 0.5, 0.8273268353539885, 1};
static const double WEIGHT[5] = {0.05, 0.2722222222222222, 0.35555555555555557, 0.2722222222222222, 0.05};
static const double PUSH[4][4] = {
    {0.008633658232300572, 0.007142857142857143, -0.0010485802534074922, 0.00018007577268406335},
    {0.025, 0.0883028192565151, 0.0125, -0.0008028192565151112},
    {0.041366341767699426, 0.17839135279874452, 0.11533429453912178, 0.007142857142857143},
    {0.05, 0.22521674962414134, 0.17777777777777778, 0.04700547259808089}};
static double ahead[4][5], push[4][4]; /* from the last step to this one; h² A */

struct block {
  _Alignas(64) double q[3][MOST], v[3][MOST];
  _Alignas(64) double w[5][3][MOST], s[5][MOST];   /* of the last step, and at its end */
  _Alignas(64) double m[5][3][MOST];               /* at the start, and at the four places */
  _Alignas(64) double Q[4][3][MOST], n[4][3][MOST];
  _Alignas(64) double x[4][3][MOST], t[4][MOST];   /* w and s of this step */
  _Alignas(64) double g[4][MOST], a[4][4][MOST], off[MOST];
};

static void tables(void) {
  double past[5] = {-1, NODE[1] - 1, NODE[2] - 1, NODE[3] - 1, 0};
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 5; j++) {
      ahead[i][j] = 1;
      for (int k = 0; k < 5; k++) ahead[i][j] *= k == j ? 1 : (NODE[i] - past[k]) / (past[j] - past[k]);
      if (j < 4) push[i][j] = H * H * PUSH[i][j];
    }
}

#define LOOK(x, y, z, g, a, b, c)                                                               \
  double t_##g = (x) * (x) + (y) * (y), f_##g = t_##g * t_##g - ((x) * (x) - (y) * (y));         \
  double g = f_##g * f_##g + ((z) * (z) - R2);                                                    \
  double a = (x) * f_##g * (4 * t_##g - 2), b = (y) * f_##g * (4 * t_##g + 2), c = (z)

/* m, s and w where a trajectory is, from g̈ = 0. */
#define PULL(i)                                                                                               \
  do {                                                                                                         \
    double X = p->q[0][i], Y = p->q[1][i], Z = p->q[2][i], u = p->v[0][i], v = p->v[1][i], w = p->v[2][i];    \
    LOOK(X, Y, Z, g, a, b, c);                                                                                 \
    (void)g;                                                                                                   \
    double along = X * (4 * t_g - 2) * u + Y * (4 * t_g + 2) * v, turn = X * u + Y * v;                        \
    double half = along * along + w * w + f_g * (8 * turn * turn + (4 * t_g - 2) * u * u + (4 * t_g + 2) * v * v); \
    double s = (c - half) / (2 * (a * a + b * b + c * c));                                                     \
    p->m[0][0][i] = a, p->m[0][1][i] = b, p->m[0][2][i] = c, p->s[4][i] = s;                                   \
    p->w[4][0][i] = 2 * s * a, p->w[4][1][i] = 2 * s * b, p->w[4][2][i] = 2 * s * c - 1;                       \
  } while (0)

INLINE long step(struct block *restrict p, int L) {
  STAGES EACH {
    double s = ahead[k][4] * p->s[4][i];
    for (int j = 0; j < 4; j++) s += ahead[k][j] * p->s[j][i];
    p->t[k][i] = s;
  }
  AXES EACH {
    double x[4];
    STAGES {
      x[k] = ahead[k][4] * p->w[4][d][i];
      for (int j = 0; j < 4; j++) x[k] += ahead[k][j] * p->w[j][d][i];
    }
    STAGES p->Q[k][d][i] = p->q[d][i] + H * NODE[k + 1] * p->v[d][i]
                           + (push[k][0] * x[0] + push[k][1] * x[1] + push[k][2] * x[2] + push[k][3] * x[3]);
  }
  double before = 0;
  long pass = 0;
  for (; pass < 30;) {
    STAGES EACH {
      LOOK(p->Q[k][0][i], p->Q[k][1][i], p->Q[k][2][i], g, a, b, c);
      p->g[k][i] = 0.5 * g, p->m[k + 1][0][i] = a, p->m[k + 1][1][i] = b, p->m[k + 1][2][i] = c;
    }
    if (!pass) EACH {
      double a[4][4];
      for (int k = 0; k < 4; k++)
        for (int j = 0; j < 4; j++)
          a[k][j] = 2 * push[k][j] * (p->m[k + 1][0][i] * p->m[j][0][i] + p->m[k + 1][1][i] * p->m[j][1][i] + p->m[k + 1][2][i] * p->m[j][2][i]);
      for (int j = 0; j < 4; j++) {
        a[j][j] = 1 / a[j][j];
        for (int k = j + 1; k < 4; k++) {
          a[k][j] *= a[j][j];
          for (int l = j + 1; l < 4; l++) a[k][l] -= a[k][j] * a[j][l];
        }
      }
      for (int k = 0; k < 4; k++) for (int j = 0; j < 4; j++) p->a[k][j][i] = a[k][j];
    }
    AXES EACH {
      double x[4];
      STAGES x[k] = 2 * p->t[k][i] * p->m[k][d][i] - (d == 2);
      STAGES {
        double n = p->q[d][i] + H * NODE[k + 1] * p->v[d][i]
                   + (push[k][0] * x[0] + push[k][1] * x[1] + push[k][2] * x[2] + push[k][3] * x[3]);
        p->n[k][d][i] = n;
        p->g[k][i] += p->m[k + 1][d][i] * (n - p->Q[k][d][i]);
      }
    }
    EACH {
      double r0 = p->g[0][i], r1 = p->g[1][i], r2 = p->g[2][i], r3 = p->g[3][i];
      r1 -= p->a[1][0][i] * r0;
      r2 -= p->a[2][0][i] * r0 + p->a[2][1][i] * r1;
      r3 -= p->a[3][0][i] * r0 + p->a[3][1][i] * r1 + p->a[3][2][i] * r2;
      r3 *= p->a[3][3][i];
      r2 = (r2 - p->a[2][3][i] * r3) * p->a[2][2][i];
      r1 = (r1 - p->a[1][2][i] * r2 - p->a[1][3][i] * r3) * p->a[1][1][i];
      r0 = (r0 - p->a[0][1][i] * r1 - p->a[0][2][i] * r2 - p->a[0][3][i] * r3) * p->a[0][0][i];
      p->g[0][i] = -r0, p->g[1][i] = -r1, p->g[2][i] = -r2, p->g[3][i] = -r3;
      p->t[0][i] -= r0, p->t[1][i] -= r1, p->t[2][i] -= r2, p->t[3][i] -= r3, p->off[i] = 0;
    }
    AXES EACH {
      double x[4], off = p->off[i];
      STAGES x[k] = 2 * p->g[k][i] * p->m[k][d][i];
      STAGES {
        double to = p->n[k][d][i] + (push[k][0] * x[0] + push[k][1] * x[1] + push[k][2] * x[2] + push[k][3] * x[3]);
        double by = fabs(to - p->Q[k][d][i]);
        off = off > by ? off : by;
        p->Q[k][d][i] = to;
      }
      p->off[i] = off;
    }
    double off = 0;
    EACH off = off > p->off[i] ? off : p->off[i];
    double rate = pass ? off / before : 1;
    rate = rate < 1e-4 ? 1e-4 : rate;
    pass++;
    if (off * rate < 1e-16 || (pass > 1 && off < 1e-13 && rate > 0.3)) break;
    before = off;
  }
  EACH {
    double v[3], x[4];
    AXES {
      STAGES x[k] = 2 * p->t[k][i] * p->m[k][d][i] - (d == 2), p->w[k][d][i] = x[k];
      v[d] = p->v[d][i] + H * (WEIGHT[0] * x[0] + WEIGHT[1] * x[1] + WEIGHT[2] * x[2] + WEIGHT[3] * x[3] - (d == 2) * WEIGHT[4]);
      p->q[d][i] = p->Q[3][d][i];
    }
    STAGES p->s[k][i] = p->t[k][i];
    LOOK(p->q[0][i], p->q[1][i], p->q[2][i], g, a, b, c);
    (void)g;
    double eta = (v[0] * a + v[1] * b + v[2] * c) / (a * a + b * b + c * c);
    p->v[0][i] = v[0] - eta * a, p->v[1][i] = v[1] - eta * b, p->v[2][i] = v[2] - eta * c;
    PULL(i);
  }
  return pass;
}

INLINE void advance(struct ensemble *e, long steps, int L) {
  static struct block block;
  struct block *p = &block;
  long passes = 0;
  tables();
  for (long base = 0; base < e->padded; base += L) {
    EACH {
      AXES p->q[d][i] = e->q[d][base + i], p->v[d][i] = e->v[d][base + i];
      PULL(i);
      STAGES {
        p->s[k][i] = p->s[4][i];
        AXES p->w[k][d][i] = p->w[4][d][i];
      }
    }
    for (long k = 0; k < steps; k++) passes += step(p, L);
    EACH AXES e->q[d][base + i] = p->q[d][i], e->v[d][base + i] = p->v[d][i];
  }
  e->values += 4 * (double)passes * L, e->gradients += 4 * (double)passes * L + (double)e->padded * (double)steps;
}

#define ALL(ROW) ROW(loops_8, 8) ROW(loops_16, 16) ROW(loops_32, 32)
#define ROW(name, L) \
  static void name(struct ensemble *e, long steps) { advance(e, steps, L); }
ALL(ROW)

int main(void) {
#define ENTRY(name, L) {#name, name, L},
  const struct row rows[] = {ALL(ENTRY)};
  return converse(rows, sizeof rows / sizeof *rows);
}
