/* One register of numbers: eight with AVX-512, four with AVX2. */
#include <immintrin.h>

#ifdef __AVX512F__
typedef __m512d vec;
typedef __mmask8 mask;
#define WIDTH 8
#define SPLAT(x) _mm512_set1_pd(x)
#define LOAD(p) _mm512_load_pd(p)
#define STORE(p, x) _mm512_store_pd(p, x)
#define FMA(a, b, c) _mm512_fmadd_pd(a, b, c)
#define FNMA(a, b, c) _mm512_fnmadd_pd(a, b, c)
#define FMS(a, b, c) _mm512_fmsub_pd(a, b, c)
#define OFF(g) _mm512_cmp_pd_mask(_mm512_abs_pd(g), SPLAT(TOLERANCE), _CMP_NLE_UQ)
#define ANY(m) ((m) != 0)
#define WHERE(m, x) _mm512_maskz_mov_pd(m, x)
#define MAX(a, b) _mm512_max_pd(a, b)
#define TOTAL(x) _mm512_reduce_add_pd(x)
#define TIMES_POWER_OF_TWO(x, shifted) _mm512_scalef_pd(x, shifted - SPLAT(0x1.8p52))
INLINE vec reciprocal(vec x, int divide, int refine) { /* of 2⁻¹⁴, doubled in digits each time */
  if (divide) return SPLAT(1) / x;
  vec r = _mm512_rcp14_pd(x);
  for (int k = 0; k < refine; k++) r = FMA(r, FNMA(x, r, SPLAT(1)), r);
  return r;
}
#else
typedef __m256d vec;
typedef __m256d mask;
#define WIDTH 4
#define SPLAT(x) _mm256_set1_pd(x)
#define LOAD(p) _mm256_load_pd(p)
#define STORE(p, x) _mm256_store_pd(p, x)
#define FMA(a, b, c) _mm256_fmadd_pd(a, b, c)
#define FNMA(a, b, c) _mm256_fnmadd_pd(a, b, c)
#define FMS(a, b, c) _mm256_fmsub_pd(a, b, c)
#define OFF(g) _mm256_cmp_pd(_mm256_andnot_pd(SPLAT(-0.0), g), SPLAT(TOLERANCE), _CMP_NLE_UQ)
#define ANY(m) (_mm256_movemask_pd(m) != 0)
#define WHERE(m, x) _mm256_and_pd(m, x)
#define MAX(a, b) _mm256_max_pd(a, b)
#define TOTAL(x) ((x)[0] + (x)[1] + (x)[2] + (x)[3])
#define TIMES_POWER_OF_TWO(x, shifted) /* adds to the exponent */ \
  _mm256_castsi256_pd(                                            \
      _mm256_add_epi64(_mm256_castpd_si256(x), _mm256_slli_epi64(_mm256_castpd_si256(shifted), 52)))
INLINE vec reciprocal(vec x, int divide, int refine) {
  (void)divide, (void)refine;
  return SPLAT(1) / x;
}
#endif
