/* RATTLE on the lemniscate surface, one trajectory after the other. */
#include "opponent.h"

/* BEND: quadratically, of s |m|², a second derivative of g along the path. */
enum guess { PREVIOUS, LINEAR, QUADRATIC, CURVATURE, BEND };

/* g and m = ∇g/2. */
INLINE double value_and_half_gradient(double x, double y, double z, double m[3]) {
  double x2 = x * x, y2 = y * y, t = x2 + y2, f = t * t - (x2 - y2), f4 = 4 * f;
  m[0] = f4 * x * (t - 0.5);
  m[1] = f4 * y * (t + 0.5);
  m[2] = z;
  return f * f + (z * z - R2);
}

/* vᵀ∇²g v / 2. */
INLINE double half_bend(double x, double y, double u, double v, double w) {
  double x2 = x * x, y2 = y * y, t = x2 + y2, f = t * t - (x2 - y2);
  double a = 4 * t - 2, b = 4 * t + 2, along = x * a * u + y * b * v, spin = x * u + y * v;
  return along * along + w * w + f * (8 * spin * spin + a * u * u + b * v * v);
}

/* The displacement along −m(q) is s m: q' = q + h v + h²/2 f − s m(q). Without the projection of velocities (verlet) s grows
 * by what it would take away, and positions are the same. */
INLINE void advance(struct ensemble *e, long steps, enum guess guess, int chord, int verlet) {
  long values = 0, gradients = 0;
  for (long i = 0; i < e->padded; i++) {
    double x = e->q[0][i], y = e->q[1][i], z = e->q[2][i];
    double u = e->v[0][i], v = e->v[1][i], w = e->v[2][i];
    double s = e->s[0][i], s1 = e->s[1][i], s2 = e->s[2][i];
    double n[3], m[3];
    value_and_half_gradient(x, y, z, n);
    double square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2], inverse_square = 1 / square;
    for (long step = 0; step < steps; step++) {
      double start = guess == PREVIOUS ? s
                     : guess == LINEAR ? 2 * s - s1
                     : guess == QUADRATIC || guess == BEND
                         ? 3 * (s - s1) + s2
                         : 0.5 * H * H * (half_bend(x, y, u, v, w) - n[2]) * inverse_square;
      s2 = s1, s1 = s, s = start;
      double X = x + H * u, Y = y + H * v, Z = z + H * w - 0.5 * H * H;
      double g, r = 0;
      x = X - s * n[0], y = Y - s * n[1], z = Z - s * n[2];
      g = value_and_half_gradient(x, y, z, m);
      values++, gradients++;
      if (chord) {
        r = 0.5 / (m[0] * n[0] + m[1] * n[1] + m[2] * n[2]);
        s += g * r;
        x = X - s * n[0], y = Y - s * n[1], z = Z - s * n[2];
        g = value_and_half_gradient(x, y, z, m);
        values++, gradients++;
      }
      for (int k = 0; !(fabs(g) <= TOLERANCE) && k < 50; k++) {
        s += chord ? g * r : 0.5 * g / (m[0] * n[0] + m[1] * n[1] + m[2] * n[2]);
        x = X - s * n[0], y = Y - s * n[1], z = Z - s * n[2];
        g = value_and_half_gradient(x, y, z, m);
        values++, gradients++;
      }
      double k = s * (1 / H);
      u -= k * n[0], v -= k * n[1], w -= k * n[2] + H;
      double before = square;
      square = m[0] * m[0] + m[1] * m[1] + m[2] * m[2], inverse_square = 1 / square;
      if (!verlet || step + 1 == steps) {
        double mu = (m[0] * u + m[1] * v + m[2] * w) * inverse_square;
        u -= mu * m[0], v -= mu * m[1], w -= mu * m[2];
      }
      if (guess == BEND) {
        double ratio = before * inverse_square;
        s *= ratio, s1 *= ratio, s2 *= ratio;
      }
      n[0] = m[0], n[1] = m[1], n[2] = m[2];
    }
    e->q[0][i] = x, e->q[1][i] = y, e->q[2][i] = z;
    e->v[0][i] = u, e->v[1][i] = v, e->v[2][i] = w;
    e->s[0][i] = s, e->s[1][i] = s1, e->s[2][i] = s2;
  }
  e->values += (double)values, e->gradients += (double)gradients;
}

static void previous(struct ensemble *e, long steps) { advance(e, steps, PREVIOUS, 0, 0); }
static void linear(struct ensemble *e, long steps) { advance(e, steps, LINEAR, 0, 0); }
static void quadratic(struct ensemble *e, long steps) { advance(e, steps, QUADRATIC, 0, 0); }
static void curvature(struct ensemble *e, long steps) { advance(e, steps, CURVATURE, 0, 0); }
static void quadratic_chord(struct ensemble *e, long steps) { advance(e, steps, QUADRATIC, 1, 0); }
static void bend(struct ensemble *e, long steps) { advance(e, steps, BEND, 0, 0); }
static void bend_chord(struct ensemble *e, long steps) { advance(e, steps, BEND, 1, 0); }
static void bend_verlet(struct ensemble *e, long steps) { advance(e, steps, BEND, 0, 1); }
static void bend_chord_verlet(struct ensemble *e, long steps) { advance(e, steps, BEND, 1, 1); }

int main(void) {
  const struct row rows[] = {{"previous", previous, 1},
                             {"linear", linear, 1},
                             {"quadratic", quadratic, 1},
                             {"curvature", curvature, 1},
                             {"quadratic_chord", quadratic_chord, 1},
                             {"bend", bend, 1},
                             {"bend_chord", bend_chord, 1},
                             {"bend_verlet", bend_verlet, 1},
                             {"bend_chord_verlet", bend_chord_verlet, 1}};
  return converse(rows, sizeof rows / sizeof *rows);
}
