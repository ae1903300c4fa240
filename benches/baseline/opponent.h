/* What every opponent written in C shares: the trajectories, and the conversation with the benchmark.
 *
 * An opponent reads one request per line and answers at once, so that all of them can wait while one works:
 *
 *   rows                      names of its variants, on one line
 *   time  ROW n steps         CPU seconds of so many steps of n trajectories
 *   check ROW n steps         max |g|, max |E − E₀|, mean kinetic energy, evaluations of g and of ∇g per step;
 *                             then n lines: q, p
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#ifndef H
#define H 0.01            /* step size */
#endif
#ifndef TOLERANCE
#define TOLERANCE 1e-14   /* on |g| */
#endif
#define R2 (1.0 / 36.0)   /* r², r = 1/6; a = 1, gravity 1 */
#define INLINE static inline __attribute__((always_inline))

/* n trajectories side by side: position, velocity, and the last three displacements per ∇g/2. Arrays are padded to
 * whole blocks with copies of the last trajectory. */
struct ensemble {
  long n, padded;
  double *restrict q[3], *restrict v[3], *restrict s[3];
  double values, gradients; /* evaluations of g and of ∇g, of all trajectories together */
};

struct row {
  const char *name;
  void (*advance)(struct ensemble *, long steps);
  long block; /* trajectories that go together */
};

static double *column(long n) {
  double *x = aligned_alloc(64, ((size_t)n * sizeof(double) + 63) / 64 * 64);
  if (!x) abort();
  memset(x, 0, (size_t)n * sizeof(double));
  return x;
}

static inline struct ensemble make(long n, long block) {
  struct ensemble e = {.n = n, .padded = (n + block - 1) / block * block};
  for (int k = 0; k < 3; k++) {
    e.q[k] = column(e.padded);
    e.v[k] = column(e.padded);
    e.s[k] = column(e.padded);
  }
  for (long i = 0; i < e.padded; i++) {
    double theta = 2 * M_PI * (double)(i < n ? i : n - 1) / (double)n;
    e.q[2][i] = 1.0 / 6.0;
    e.v[0][i] = cos(theta);
    e.v[1][i] = sin(theta);
    for (int k = 0; k < 3; k++) e.s[k][i] = -3 * H * H; /* that g̈ = 0 asks for here */
  }
  return e;
}

static inline void drop(struct ensemble *e) {
  for (int k = 0; k < 3; k++) {
    free(e->q[k]);
    free(e->v[k]);
    free(e->s[k]);
  }
}

static double seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static inline void answer_time(const struct row *row, long n, long steps) {
  struct ensemble e = make(n, row->block);
  double start = seconds();
  row->advance(&e, steps);
  printf("%.9e\n", seconds() - start);
  drop(&e);
}

static inline void answer_check(const struct row *row, long n, long steps) {
  struct ensemble e = make(n, row->block);
  double worst = 0, deviation = 0, kinetic = 0;
  for (long step = 0; step < steps; step++) {
    row->advance(&e, 1);
    for (long i = 0; i < n; i++) {
      double x = e.q[0][i], y = e.q[1][i], z = e.q[2][i];
      double t = x * x + y * y, f = t * t - (x * x - y * y), g = f * f + z * z - R2;
      double k = 0.5 * (e.v[0][i] * e.v[0][i] + e.v[1][i] * e.v[1][i] + e.v[2][i] * e.v[2][i]);
      worst = fmax(worst, fabs(g));
      deviation = fmax(deviation, fabs(k + z - 0.5 - 1.0 / 6.0));
      kinetic += k;
      if (!(fabs(g) < 1)) worst = INFINITY; /* NaN too */
    }
  }
  double all = (double)e.padded * (double)steps;
  printf("%.3e %.6e %.6e %.4f %.4f\n", worst, deviation, kinetic / ((double)n * (double)steps), e.values / all,
         e.gradients / all);
  for (long i = 0; i < n; i++)
    printf("%.17g %.17g %.17g %.17g %.17g %.17g\n", e.q[0][i], e.q[1][i], e.q[2][i], e.v[0][i], e.v[1][i],
           e.v[2][i]);
  drop(&e);
}

static inline int converse(const struct row *rows, int count) {
  char line[256], word[16], name[64];
  long n, steps;
  while (fgets(line, sizeof line, stdin)) {
    if (!strncmp(line, "rows", 4)) {
      for (int i = 0; i < count; i++) printf("%s%c", rows[i].name, i + 1 < count ? ' ' : '\n');
    } else if (sscanf(line, "%15s %63s %ld %ld", word, name, &n, &steps) == 4) {
      const struct row *row = NULL;
      for (int i = 0; i < count; i++)
        if (!strcmp(rows[i].name, name)) row = &rows[i];
      if (!row) return 1;
      (!strcmp(word, "time") ? answer_time : answer_check)(row, n, steps);
    } else {
      return 1;
    }
    fflush(stdout);
  }
  return 0;
}
