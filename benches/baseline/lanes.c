/* RATTLE on the lemniscate surface in vector registers: U registers of trajectories go side by side, and RR such groups take
 * turns, so that one group's latencies are hidden behind another's work. */
#include "opponent.h"
#include "vector.h"

#define MOST 6 /* registers side by side */

enum guess { PREVIOUS, LINEAR, QUADRATIC, BEND }; /* see scalar.c */
enum solve { NEWTON, CHORD, OSTROWSKI };

struct group {
  vec q[3][MOST], v[3][MOST], n[3][MOST], s[3][MOST], square[MOST];
};

/* g and m = ∇g/2. */
INLINE vec value_and_half_gradient(const vec q[3], vec m[3]) {
  vec y2 = q[1] * q[1], t = FMA(q[0], q[0], y2), d = FMS(q[0], q[0], y2), f = FMS(t, t, d);
  m[0] = q[0] * f * FMA(SPLAT(4), t, SPLAT(-2));
  m[1] = q[1] * f * FMA(SPLAT(4), t, SPLAT(2));
  m[2] = q[2];
  return FMA(f, f, FMS(q[2], q[2], SPLAT(R2)));
}

INLINE vec value(const vec q[3]) {
  vec y2 = q[1] * q[1], t = FMA(q[0], q[0], y2), d = FMS(q[0], q[0], y2), f = FMS(t, t, d);
  return FMA(f, f, FMS(q[2], q[2], SPLAT(R2)));
}

INLINE vec dot(const vec a[3], const vec b[3]) { return FMA(a[0], b[0], FMA(a[1], b[1], a[2] * b[2])); }

/* One step of a group; returns passes through the loop. */
INLINE long step(struct group *p, int U, enum guess guess, enum solve solve, int divide, int project) {
  vec X[3][MOST], m[3][MOST], s[MOST], r[MOST], g[MOST];
  const vec h = SPLAT(H);
#define EACH for (int i = 0; i < U; i++)
#define POINT(a) vec a[3] = {FNMA(s[i], p->n[0][i], X[0][i]), FNMA(s[i], p->n[1][i], X[1][i]), FNMA(s[i], p->n[2][i], X[2][i])}
#define NORMAL {p->n[0][i], p->n[1][i], p->n[2][i]}
#pragma GCC unroll 8
  EACH {
    vec s0 = p->s[0][i], s1 = p->s[1][i], s2 = p->s[2][i];
    s[i] = guess == PREVIOUS ? s0 : guess == LINEAR ? FMS(SPLAT(2), s0, s1) : FMA(SPLAT(3), s0 - s1, s2);
    p->s[1][i] = s0;
    if (guess == QUADRATIC || guess == BEND) p->s[2][i] = s1;
    X[0][i] = FMA(h, p->v[0][i], p->q[0][i]);
    X[1][i] = FMA(h, p->v[1][i], p->q[1][i]);
    X[2][i] = FMA(h, p->v[2][i], p->q[2][i] - SPLAT(0.5 * H * H));
    const vec n[3] = NORMAL;
    {
      POINT(a);
      vec b[3];
      g[i] = value_and_half_gradient(a, b);
      r[i] = SPLAT(0.5) * reciprocal(dot(b, n), divide, solve == NEWTON ? 2 : 1);
      s[i] = FMA(g[i], r[i], s[i]);
      POINT(c);
      if (solve == CHORD) {
        s[i] = FMA(value(c), r[i], s[i]);
      } else if (solve == OSTROWSKI) {
        vec next = value(c), ratio = next * reciprocal(g[i] + SPLAT(1e-300), 0, 0);
        s[i] = FMA(next * r[i], FMA(SPLAT(2), ratio, SPLAT(1)), s[i]);
      } else {
        g[i] = value_and_half_gradient(c, b);
        r[i] = SPLAT(0.5) * reciprocal(dot(b, n), divide, 2);
        s[i] = FMA(g[i], r[i], s[i]);
      }
    }
  }
  long passes = 1;
  for (;; passes++) {
    mask off[MOST];
    int any = 0;
#pragma GCC unroll 8
    EACH {
      POINT(a);
      vec b[3];
      g[i] = value_and_half_gradient(a, b);
      m[0][i] = b[0], m[1][i] = b[1], m[2][i] = b[2];
      p->q[0][i] = a[0], p->q[1][i] = a[1], p->q[2][i] = a[2];
      off[i] = OFF(g[i]);
      any |= ANY(off[i]);
    }
    if (__builtin_expect(!any || passes > 50, 1)) break;
#pragma GCC unroll 8
    EACH {
      const vec b[3] = {m[0][i], m[1][i], m[2][i]}, n[3] = NORMAL;
      if (solve == NEWTON) r[i] = SPLAT(0.5) * reciprocal(dot(b, n), divide, 2);
      s[i] += WHERE(off[i], g[i] * r[i]);
    }
  }
#pragma GCC unroll 8
  EACH {
    vec k = s[i] * SPLAT(1 / H), v[3];
    v[0] = FNMA(k, p->n[0][i], p->v[0][i]);
    v[1] = FNMA(k, p->n[1][i], p->v[1][i]);
    v[2] = FNMA(k, p->n[2][i], p->v[2][i] - h);
    const vec b[3] = {m[0][i], m[1][i], m[2][i]};
    vec square = dot(b, b), inverse = reciprocal(square, divide, 2);
    if (project) {
      vec mu = dot(b, v) * inverse;
      for (int c = 0; c < 3; c++) v[c] = FNMA(mu, b[c], v[c]);
    }
    for (int c = 0; c < 3; c++) p->v[c][i] = v[c], p->n[c][i] = b[c];
    p->s[0][i] = s[i];
    if (guess == BEND) {
      vec ratio = p->square[i] * inverse;
      for (int k = 0; k < 3; k++) p->s[k][i] *= ratio;
      p->square[i] = square;
    }
  }
  return passes;
}

INLINE void advance(struct ensemble *e, long steps, int U, int RR, enum guess guess, enum solve solve, int divide, int verlet) {
  struct group groups[2];
  long passes = 0;
  for (long base = 0; base < e->padded; base += RR * U * WIDTH) {
    for (int j = 0; j < RR; j++)
#pragma GCC unroll 8
      EACH {
        struct group *p = &groups[j];
        long at = base + (j * U + i) * WIDTH;
        vec q[3], n[3];
        for (int c = 0; c < 3; c++) {
          q[c] = p->q[c][i] = LOAD(e->q[c] + at);
          p->v[c][i] = LOAD(e->v[c] + at);
          p->s[c][i] = LOAD(e->s[c] + at);
        }
        value_and_half_gradient(q, n);
        for (int c = 0; c < 3; c++) p->n[c][i] = n[c];
        p->square[i] = dot(n, n);
      }
    for (long k = 0; k < steps - verlet; k++)
      for (int j = 0; j < RR; j++) passes += step(&groups[j], U, guess, solve, divide, !verlet);
    if (verlet)
      for (int j = 0; j < RR; j++) passes += step(&groups[j], U, guess, solve, divide, 1);
    for (int j = 0; j < RR; j++)
#pragma GCC unroll 8
      EACH {
        struct group *p = &groups[j];
        long at = base + (j * U + i) * WIDTH;
        for (int c = 0; c < 3; c++) {
          STORE(e->q[c] + at, p->q[c][i]);
          STORE(e->v[c] + at, p->v[c][i]);
          STORE(e->s[c] + at, p->s[c][i]);
        }
      }
  }
  double lanes = (double)passes * U * WIDTH, all = (double)e->padded * (double)steps;
  e->values += lanes + 2 * all;
  e->gradients += lanes + (solve == NEWTON ? 2 : 1) * all;
}

#define ROW(name, u, rr, guess, solve, divide, verlet) \
  static void name(struct ensemble *e, long steps) { advance(e, steps, u, rr, guess, solve, divide, verlet); }
#define ROWS(ROW, u)                                                       \
  ROW(linear_ostrowski_u##u, u, 1, LINEAR, OSTROWSKI, 1, 0)                   \
  ROW(linear_ostrowski_u##u##_rr2, u, 2, LINEAR, OSTROWSKI, 1, 0)             \
  ROW(quadratic_ostrowski_u##u, u, 1, QUADRATIC, OSTROWSKI, 1, 0)             \
  ROW(quadratic_ostrowski_u##u##_rr2, u, 2, QUADRATIC, OSTROWSKI, 1, 0)       \
  ROW(quadratic_ostrowski_rcp_u##u, u, 1, QUADRATIC, OSTROWSKI, 0, 0)         \
  ROW(quadratic_chord_u##u, u, 1, QUADRATIC, CHORD, 1, 0)                     \
  ROW(quadratic_chord_u##u##_rr2, u, 2, QUADRATIC, CHORD, 1, 0)               \
  ROW(linear_newton_rcp_u##u##_rr2, u, 2, LINEAR, NEWTON, 0, 0)               \
  ROW(previous_newton_u##u, u, 1, PREVIOUS, NEWTON, 1, 0) \
  ROW(bend_ostrowski_u##u, u, 1, BEND, OSTROWSKI, 1, 0) \
  ROW(bend_chord_u##u, u, 1, BEND, CHORD, 1, 0) \
  ROW(bend_ostrowski_verlet_u##u, u, 1, BEND, OSTROWSKI, 1, 1) \
  ROW(bend_ostrowski_rcp_verlet_u##u, u, 1, BEND, OSTROWSKI, 0, 1) \
  ROW(bend_ostrowski_verlet_u##u##_rr2, u, 2, BEND, OSTROWSKI, 1, 1)
#define ALL(ROW) ROWS(ROW, 1) ROWS(ROW, 2) ROWS(ROW, 3) ROWS(ROW, 4) ROWS(ROW, 5) ROWS(ROW, 6)
ALL(ROW)

int main(void) {
#define ENTRY(name, u, rr, ...) {#name, name, u * rr * WIDTH},
  const struct row rows[] = {ALL(ENTRY)};
  return converse(rows, sizeof rows / sizeof *rows);
}
