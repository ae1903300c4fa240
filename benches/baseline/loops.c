/* RATTLE on the lemniscate surface as plain loops over blocks of trajectories, for the compiler to vectorise. */
#include "opponent.h"

enum guess { PREVIOUS, LINEAR, QUADRATIC, BEND }; /* see scalar.c */
enum solve { NEWTON, CHORD, OSTROWSKI };

#define MOST 64

struct block {
  _Alignas(64) double q[3][MOST];
  _Alignas(64) double v[3][MOST];
  _Alignas(64) double n[3][MOST];
  _Alignas(64) double m[3][MOST];
  _Alignas(64) double X[3][MOST];
  _Alignas(64) double s[3][MOST];
  _Alignas(64) double g[MOST];
  _Alignas(64) double square[MOST];
  _Alignas(64) double r[MOST];
};

/* g and m = ∇g/2. */
#define VALUE_AND_HALF_GRADIENT(x, y, z, g, a, b, c)                                 \
  double x2_##g = (x) * (x), y2_##g = (y) * (y), t_##g = x2_##g + y2_##g;            \
  double f_##g = t_##g * t_##g - (x2_##g - y2_##g);                                  \
  double g = f_##g * f_##g + ((z) * (z) - R2);                                       \
  double a = (x) * f_##g * (4 * t_##g - 2), b = (y) * f_##g * (4 * t_##g + 2), c = (z); \
  (void)a, (void)b, (void)c

/* One step of a block; returns how often its last loop was passed. */
INLINE long step(struct block *restrict p, int L, enum guess guess, enum solve solve) {
  for (int i = 0; i < L; i++) {
    double s0 = p->s[0][i], s1 = p->s[1][i], s2 = p->s[2][i];
    double s = guess == PREVIOUS ? s0 : guess == LINEAR ? 2 * s0 - s1 : 3 * (s0 - s1) + s2;
    if (guess != PREVIOUS) p->s[1][i] = s0;
    if (guess == QUADRATIC || guess == BEND) p->s[2][i] = s1;
    double X = p->q[0][i] + H * p->v[0][i], Y = p->q[1][i] + H * p->v[1][i];
    double Z = p->q[2][i] - 0.5 * H * H + H * p->v[2][i];
    p->X[0][i] = X, p->X[1][i] = Y, p->X[2][i] = Z;
    double nx = p->n[0][i], ny = p->n[1][i], nz = p->n[2][i];
    if (solve != NEWTON) {
      VALUE_AND_HALF_GRADIENT(X - s * nx, Y - s * ny, Z - s * nz, g, a, b, c);
      double r = 0.5 / (a * nx + b * ny + c * nz);
      s += g * r;
      VALUE_AND_HALF_GRADIENT(X - s * nx, Y - s * ny, Z - s * nz, k, d, e, f);
      s += solve == CHORD ? k * r : k * r * (1 + 2 * k / (g + 1e-300));
      p->r[i] = r;
    }
    p->s[0][i] = s;
  }
  long passes = 1;
  for (;; passes++) {
    double worst = 0;
    for (int i = 0; i < L; i++) {
      double s = p->s[0][i], nx = p->n[0][i], ny = p->n[1][i], nz = p->n[2][i];
      double x = p->X[0][i] - s * nx, y = p->X[1][i] - s * ny, z = p->X[2][i] - s * nz;
      VALUE_AND_HALF_GRADIENT(x, y, z, g, a, b, c);
      p->q[0][i] = x, p->q[1][i] = y, p->q[2][i] = z;
      p->m[0][i] = a, p->m[1][i] = b, p->m[2][i] = c;
      p->g[i] = g;
      if (solve == NEWTON) p->r[i] = 0.5 / (a * nx + b * ny + c * nz);
      double size = fabs(g);
      worst = worst > size ? worst : size;
    }
    if (worst <= TOLERANCE || passes > 50) break;
    for (int i = 0; i < L; i++) {
      double g = p->g[i];
      p->s[0][i] += fabs(g) <= TOLERANCE ? 0 : g * p->r[i];
    }
  }
  for (int i = 0; i < L; i++) {
    double k = p->s[0][i] * (1 / H);
    double u = p->v[0][i] - k * p->n[0][i], v = p->v[1][i] - k * p->n[1][i], w = p->v[2][i] - H - k * p->n[2][i];
    double a = p->m[0][i], b = p->m[1][i], c = p->m[2][i];
    double square = a * a + b * b + c * c, inverse = 1 / square, mu = (a * u + b * v + c * w) * inverse;
    if (guess == BEND) {
      double ratio = p->square[i] * inverse;
      p->s[0][i] *= ratio, p->s[1][i] *= ratio, p->s[2][i] *= ratio, p->square[i] = square;
    }
    p->v[0][i] = u - mu * a, p->v[1][i] = v - mu * b, p->v[2][i] = w - mu * c;
    p->n[0][i] = a, p->n[1][i] = b, p->n[2][i] = c;
  }
  return passes;
}

INLINE void advance(struct ensemble *e, long steps, int L, enum guess guess, enum solve solve) {
  static struct block p;
  long passes = 0;
  for (long base = 0; base < e->padded; base += L) {
    for (int i = 0; i < L; i++) {
      for (int c = 0; c < 3; c++) {
        p.q[c][i] = e->q[c][base + i];
        p.v[c][i] = e->v[c][base + i];
        p.s[c][i] = e->s[c][base + i];
      }
      VALUE_AND_HALF_GRADIENT(p.q[0][i], p.q[1][i], p.q[2][i], g, a, b, c);
      (void)g;
      p.n[0][i] = a, p.n[1][i] = b, p.n[2][i] = c, p.square[i] = a * a + b * b + c * c;
    }
    for (long k = 0; k < steps; k++) passes += step(&p, L, guess, solve);
    for (int i = 0; i < L; i++)
      for (int c = 0; c < 3; c++) {
        e->q[c][base + i] = p.q[c][i];
        e->v[c][base + i] = p.v[c][i];
        e->s[c][base + i] = p.s[c][i];
      }
  }
  double lanes = (double)passes * L, all = (double)e->padded * (double)steps;
  e->values += lanes + (solve == NEWTON ? 0 : 2 * all);
  e->gradients += lanes + (solve == NEWTON ? 0 : all);
}

#define ALL(ROW)                                        \
  ROW(previous_newton_32, 32, PREVIOUS, NEWTON)         \
  ROW(quadratic_newton_32, 32, QUADRATIC, NEWTON)       \
  ROW(quadratic_chord_32, 32, QUADRATIC, CHORD)         \
  ROW(linear_ostrowski_64, 64, LINEAR, OSTROWSKI)       \
  ROW(quadratic_ostrowski_24, 24, QUADRATIC, OSTROWSKI) \
  ROW(quadratic_ostrowski_32, 32, QUADRATIC, OSTROWSKI) \
  ROW(quadratic_ostrowski_48, 48, QUADRATIC, OSTROWSKI) \
  ROW(quadratic_ostrowski_64, 64, QUADRATIC, OSTROWSKI) \
  ROW(bend_ostrowski_32, 32, BEND, OSTROWSKI)           \
  ROW(bend_ostrowski_64, 64, BEND, OSTROWSKI)

#define ROW(name, L, guess, solve) \
  static void name(struct ensemble *e, long steps) { advance(e, steps, L, guess, solve); }
ALL(ROW)

int main(void) {
#define ENTRY(name, L, ...) {#name, name, L},
  const struct row rows[] = {ALL(ENTRY)};
  return converse(rows, sizeof rows / sizeof *rows);
}
