/* From musl (https://musl.libc.org, commit 86373b49; its licence is in the documentation's licenses), by the files that are
   named below. Changed: all names are local, with prefixes, and code for fused multiplication and for long double is left
   out, so that the same bits come out everywhere. mathematics.h includes this. */
#pragma GCC system_header

/* ---- exp.c ---- */
/*
 * Double-precision e^x function.
 *
 * Copyright (c) 2018, Arm Limited.
 * SPDX-License-Identifier: MIT
 */


#define exp_N (1 << MUSL_EXP_TABLE_BITS)
#define exp_InvLn2N musl_exp_data.invln2N
#define exp_NegLn2hiN musl_exp_data.negln2hiN
#define exp_NegLn2loN musl_exp_data.negln2loN
#define exp_Shift musl_exp_data.shift
#define exp_T musl_exp_data.tab
#define exp_C2 musl_exp_data.poly[5 - MUSL_EXP_POLY_ORDER]
#define exp_C3 musl_exp_data.poly[6 - MUSL_EXP_POLY_ORDER]
#define exp_C4 musl_exp_data.poly[7 - MUSL_EXP_POLY_ORDER]
#define exp_C5 musl_exp_data.poly[8 - MUSL_EXP_POLY_ORDER]

/* Handle cases that may overflow or underflow when computing the result that
   is scale*(1+TMP) without intermediate rounding.  The bit representation of
   scale is in SBITS, however it has a computed exponent that may have
   overflown into the sign bit so that needs to be adjusted before using it as
   a double.  (int32_t)KI is the k used in the argument reduction and exponent
   adjustment of scale, positive k here means the result may overflow and
   negative k means the result may underflow.  */
static inline double exp_specialcase(double tmp, uint64_t sbits, uint64_t ki)
{
	double scale, y;

	if ((ki & 0x80000000) == 0) {
		/* k > 0, the exponent of scale might have overflowed by <= 460.  */
		sbits -= 1009ull << 52;
		scale = musl_asdouble(sbits);
		y = 0x1p1009 * (scale + scale * tmp);
		return (y);
	}
	/* k < 0, need special care in the subnormal range.  */
	sbits += 1022ull << 52;
	scale = musl_asdouble(sbits);
	y = scale + scale * tmp;
	if (y < 1.0) {
		/* Round y to the right precision before scaling it into the subnormal
		 range to avoid double rounding that can cause 0.5+E/2 ulp error where
		 E is the worst-case ulp error outside the subnormal range.  So this
		 is only useful if the goal is better than 1 ulp worst-case error.  */
		double hi, lo;
		lo = scale - y + scale * tmp;
		hi = 1.0 + y;
		lo = 1.0 - hi + y + lo;
		y = (hi + lo) - 1.0;
		/* Avoid -0.0 with downward rounding.  */
		if (y == 0.0)
			y = 0.0;
		/* The underflow exception needs to be signaled explicitly.  */
	}
	y = 0x1p-1022 * y;
	return (y);
}

/* Top 12 bits of a double (sign and exponent bits).  */
static inline uint32_t exp_top12(double x)
{
	return musl_asuint64(x) >> 52;
}

static APART double musl_exp(double x)
{
	uint32_t abstop;
	uint64_t ki, idx, top, sbits;
	double kd, z, r, r2, scale, tail, tmp;

	abstop = exp_top12(x) & 0x7ff;
	if (RARELY(abstop - exp_top12(0x1p-54) >= exp_top12(512.0) - exp_top12(0x1p-54))) {
		if (abstop - exp_top12(0x1p-54) >= 0x80000000)
			/* Avoid spurious underflow for tiny x.  */
			/* Note: 0 is common input.  */
			return 1.0 + x;
		if (abstop >= exp_top12(1024.0)) {
			if (musl_asuint64(x) == musl_asuint64(-INFINITY))
				return 0.0;
			if (abstop >= exp_top12(INFINITY))
				return 1.0 + x;
			if (musl_asuint64(x) >> 63)
				return musl_math_uflow(0);
			else
				return musl_math_oflow(0);
		}
		/* Large x is special cased below.  */
		abstop = 0;
	}

	/* exp(x) = 2^(k/exp_N) * exp(r), with exp(r) in [2^(-1/2N),2^(1/2N)].  */
	/* x = ln2/exp_N*k + r, with int k and r in [-ln2/2N, ln2/2N].  */
	z = exp_InvLn2N * x;
	/* z - kd is in [-1, 1] in non-nearest rounding modes.  */
	kd = (z + exp_Shift);
	ki = musl_asuint64(kd);
	kd -= exp_Shift;
	r = x + kd * exp_NegLn2hiN + kd * exp_NegLn2loN;
	/* 2^(k/exp_N) ~= scale * (1 + tail).  */
	idx = 2 * (ki % exp_N);
	top = ki << (52 - MUSL_EXP_TABLE_BITS);
	tail = musl_asdouble(exp_T[idx]);
	/* This is only a valid scale when -1023*exp_N < k < 1024*N.  */
	sbits = exp_T[idx + 1] + top;
	/* exp(x) = 2^(k/exp_N) * exp(r) ~= scale + scale * (tail + exp(r) - 1).  */
	/* Evaluation is optimized assuming superscalar pipelined execution.  */
	r2 = r * r;
	/* Without fma the worst case error is 0.25/exp_N ulp larger.  */
	/* Worst case error is less than 0.5+1.11/exp_N+(abs poly error * 2^53) ulp.  */
	tmp = tail + r + r2 * (exp_C2 + r * exp_C3) + r2 * r2 * (exp_C4 + r * exp_C5);
	if (RARELY(abstop == 0))
		return exp_specialcase(tmp, sbits, ki);
	scale = musl_asdouble(sbits);
	/* Note: tmp == 0 or |tmp| > 2^-200 and scale > 2^-739, so there
	   is no spurious underflow here even without fma.  */
	return (scale + scale * tmp);
}

/* ---- log.c ---- */
/*
 * Double-precision log(x) function.
 *
 * Copyright (c) 2018, Arm Limited.
 * SPDX-License-Identifier: MIT
 */


#define log_T musl_log_data.tab
#define log_T2 musl_log_data.tab2
#define log_B musl_log_data.poly1
#define log_A musl_log_data.poly
#define log_Ln2hi musl_log_data.ln2hi
#define log_Ln2lo musl_log_data.ln2lo
#define log_N (1 << MUSL_LOG_TABLE_BITS)
#define log_OFF 0x3fe6000000000000

/* Top 16 bits of a double.  */
static inline uint32_t log_top16(double x)
{
	return musl_asuint64(x) >> 48;
}

static APART double musl_log(double x)
{
	double w, z, r, r2, r3, y, invc, logc, kd, hi, lo;
	uint64_t ix, iz, tmp;
	uint32_t top;
	int k, i;

	ix = musl_asuint64(x);
	top = log_top16(x);
#define log_LO musl_asuint64(1.0 - 0x1p-4)
#define log_HI musl_asuint64(1.0 + 0x1.09p-4)
	if (RARELY(ix - log_LO < log_HI - log_LO)) {
		/* Handle close to 1.0 inputs separately.  */
		/* Fix sign of zero with downward rounding when x==1.  */
		if (RARELY(ix == musl_asuint64(1.0)))
			return 0;
		r = x - 1.0;
		r2 = r * r;
		r3 = r * r2;
		y = r3 *
		    (log_B[1] + r * log_B[2] + r2 * log_B[3] +
		     r3 * (log_B[4] + r * log_B[5] + r2 * log_B[6] +
			   r3 * (log_B[7] + r * log_B[8] + r2 * log_B[9] + r3 * log_B[10])));
		/* Worst-case error is around 0.507 ULP.  */
		w = r * 0x1p27;
		double rhi = r + w - w;
		double rlo = r - rhi;
		w = rhi * rhi * log_B[0]; /* log_B[0] == -0.5.  */
		hi = r + w;
		lo = r - hi + w;
		lo += log_B[0] * rlo * (rhi + r);
		y += lo;
		y += hi;
		return (y);
	}
	if (RARELY(top - 0x0010 >= 0x7ff0 - 0x0010)) {
		/* x < 0x1p-1022 or inf or nan.  */
		if (ix * 2 == 0)
			return musl_math_divzero(1);
		if (ix == musl_asuint64(INFINITY)) /* log(inf) == inf.  */
			return x;
		if ((top & 0x8000) || (top & 0x7ff0) == 0x7ff0)
			return musl_math_invalid(x);
		/* x is subnormal, normalize it.  */
		ix = musl_asuint64(x * 0x1p52);
		ix -= 52ULL << 52;
	}

	/* x = 2^k z; where z is in range [log_OFF,2*log_OFF) and exact.
	   The range is split into log_N subintervals.
	   The ith subinterval contains z and c is near its center.  */
	tmp = ix - log_OFF;
	i = (tmp >> (52 - MUSL_LOG_TABLE_BITS)) % log_N;
	k = (int64_t)tmp >> 52; /* arithmetic shift */
	iz = ix - (tmp & 0xfffULL << 52);
	invc = log_T[i].invc;
	logc = log_T[i].logc;
	z = musl_asdouble(iz);

	/* log(x) = log1p(z/c-1) + log(c) + k*Ln2.  */
	/* r ~= z/c - 1, |r| < 1/(2*log_N).  */
	/* rounding error: 0x1p-55/log_N + 0x1p-66.  */
	r = (z - log_T2[i].chi - log_T2[i].clo) * invc;
	kd = (double)k;

	/* hi + lo = r + log(c) + k*Ln2.  */
	w = kd * log_Ln2hi + logc;
	hi = w + r;
	lo = w - hi + r + kd * log_Ln2lo;

	/* log(x) = lo + (log1p(r) - r) + hi.  */
	r2 = r * r; /* rounding error: 0x1p-54/log_N^2.  */
	/* Worst case error if |y| > 0x1p-5:
	   0.5 + 4.13/log_N + abs-poly-error*2^57 ULP (+ 0.002 ULP without fma)
	   Worst case error if |y| > 0x1p-4:
	   0.5 + 2.06/log_N + abs-poly-error*2^56 ULP (+ 0.001 ULP without fma).  */
	y = lo + r2 * log_A[0] +
	    r * r2 * (log_A[1] + r * log_A[2] + r2 * (log_A[3] + r * log_A[4])) + hi;
	return (y);
}

/* ---- pow.c ---- */
/*
 * Double-precision x^y function.
 *
 * Copyright (c) 2018, Arm Limited.
 * SPDX-License-Identifier: MIT
 */


/*
Worst-case error: 0.54 ULP (~= ulperr_exp + 1024*Ln2*relerr_log*2^53)
relerr_log: 1.3 * 2^-68 (Relative error of log, 1.5 * 2^-68 without fma)
ulperr_exp: 0.509 ULP (ULP error of exp, 0.511 ULP without fma)
*/

#define pow_T musl_pow_data.tab
#define pow_A musl_pow_data.poly
#define pow_Ln2hi musl_pow_data.ln2hi
#define pow_Ln2lo musl_pow_data.ln2lo
#define pow_N (1 << MUSL_POW_LOG_TABLE_BITS)
#define pow_OFF 0x3fe6955500000000

/* Top 12 bits of a double (sign and exponent bits).  */
static inline uint32_t pow_top12(double x)
{
	return musl_asuint64(x) >> 52;
}

/* Compute y+TAIL = log(x) where the rounded result is y and TAIL has about
   additional 15 bits precision.  IX is the bit representation of x, but
   normalized in the subnormal range using the sign bit for the exponent.  */
static inline double pow_log_inline(uint64_t ix, double *tail)
{
	/* double for better performance on targets with FLT_EVAL_METHOD==2.  */
	double z, r, y, invc, logc, logctail, kd, hi, t1, t2, lo, lo1, lo2, p;
	uint64_t iz, tmp;
	int k, i;

	/* x = 2^k z; where z is in range [pow_OFF,2*pow_OFF) and exact.
	   The range is split into pow_N subintervals.
	   The ith subinterval contains z and c is near its center.  */
	tmp = ix - pow_OFF;
	i = (tmp >> (52 - MUSL_POW_LOG_TABLE_BITS)) % pow_N;
	k = (int64_t)tmp >> 52; /* arithmetic shift */
	iz = ix - (tmp & 0xfffULL << 52);
	z = musl_asdouble(iz);
	kd = (double)k;

	/* log(x) = k*Ln2 + log(c) + log1p(z/c-1).  */
	invc = pow_T[i].invc;
	logc = pow_T[i].logc;
	logctail = pow_T[i].logctail;

	/* Note: 1/c is j/pow_N or j/pow_N/2 where j is an integer in [pow_N,2N) and
     |z/c - 1| < 1/pow_N, so r = z/c - 1 is exactly representible.  */
	/* Split z such that rhi, rlo and rhi*rhi are exact and |rlo| <= |r|.  */
	double zhi = musl_asdouble((iz + (1ULL << 31)) & (-1ULL << 32));
	double zlo = z - zhi;
	double rhi = zhi * invc - 1.0;
	double rlo = zlo * invc;
	r = rhi + rlo;

	/* k*Ln2 + log(c) + r.  */
	t1 = kd * pow_Ln2hi + logc;
	t2 = t1 + r;
	lo1 = kd * pow_Ln2lo + logctail;
	lo2 = t1 - t2 + r;

	/* Evaluation is optimized assuming superscalar pipelined execution.  */
	double ar, ar2, ar3, lo3, lo4;
	ar = pow_A[0] * r; /* pow_A[0] = -0.5.  */
	ar2 = r * ar;
	ar3 = r * ar2;
	/* k*Ln2 + log(c) + r + pow_A[0]*r*r.  */
	double arhi = pow_A[0] * rhi;
	double arhi2 = rhi * arhi;
	hi = t2 + arhi2;
	lo3 = rlo * (ar + arhi);
	lo4 = t2 - hi + arhi2;
	/* p = log1p(r) - r - pow_A[0]*r*r.  */
	p = (ar3 * (pow_A[1] + r * pow_A[2] +
		    ar2 * (pow_A[3] + r * pow_A[4] + ar2 * (pow_A[5] + r * pow_A[6]))));
	lo = lo1 + lo2 + lo3 + lo4 + p;
	y = hi + lo;
	*tail = hi - y + lo;
	return y;
}

#undef pow_N
#undef pow_T
#define pow_N (1 << MUSL_EXP_TABLE_BITS)
#define pow_InvLn2N musl_exp_data.invln2N
#define pow_NegLn2hiN musl_exp_data.negln2hiN
#define pow_NegLn2loN musl_exp_data.negln2loN
#define pow_Shift musl_exp_data.shift
#define pow_T musl_exp_data.tab
#define pow_C2 musl_exp_data.poly[5 - MUSL_EXP_POLY_ORDER]
#define pow_C3 musl_exp_data.poly[6 - MUSL_EXP_POLY_ORDER]
#define pow_C4 musl_exp_data.poly[7 - MUSL_EXP_POLY_ORDER]
#define pow_C5 musl_exp_data.poly[8 - MUSL_EXP_POLY_ORDER]
#define pow_C6 musl_exp_data.poly[9 - MUSL_EXP_POLY_ORDER]

/* Handle cases that may overflow or underflow when computing the result that
   is scale*(1+TMP) without intermediate rounding.  The bit representation of
   scale is in SBITS, however it has a computed exponent that may have
   overflown into the sign bit so that needs to be adjusted before using it as
   a double.  (int32_t)KI is the k used in the argument reduction and exponent
   adjustment of scale, positive k here means the result may overflow and
   negative k means the result may underflow.  */
static inline double pow_specialcase(double tmp, uint64_t sbits, uint64_t ki)
{
	double scale, y;

	if ((ki & 0x80000000) == 0) {
		/* k > 0, the exponent of scale might have overflowed by <= 460.  */
		sbits -= 1009ull << 52;
		scale = musl_asdouble(sbits);
		y = 0x1p1009 * (scale + scale * tmp);
		return (y);
	}
	/* k < 0, need special care in the subnormal range.  */
	sbits += 1022ull << 52;
	/* Note: sbits is signed scale.  */
	scale = musl_asdouble(sbits);
	y = scale + scale * tmp;
	if (fabs(y) < 1.0) {
		/* Round y to the right precision before scaling it into the subnormal
		   range to avoid double rounding that can cause 0.5+E/2 ulp error where
		   E is the worst-case ulp error outside the subnormal range.  So this
		   is only useful if the goal is better than 1 ulp worst-case error.  */
		double hi, lo, one = 1.0;
		if (y < 0.0)
			one = -1.0;
		lo = scale - y + scale * tmp;
		hi = one + y;
		lo = one - hi + y + lo;
		y = (hi + lo) - one;
		/* Fix the sign of 0.  */
		if (y == 0.0)
			y = musl_asdouble(sbits & 0x8000000000000000);
		/* The underflow exception needs to be signaled explicitly.  */
	}
	y = 0x1p-1022 * y;
	return (y);
}

#define pow_SIGN_BIAS (0x800 << MUSL_EXP_TABLE_BITS)

/* Computes sign*exp(x+xtail) where |xtail| < 2^-8/pow_N and |xtail| <= |x|.
   The sign_bias argument is pow_SIGN_BIAS or 0 and sets the sign to -1 or 1.  */
static inline double pow_exp_inline(double x, double xtail, uint32_t sign_bias)
{
	uint32_t abstop;
	uint64_t ki, idx, top, sbits;
	/* double for better performance on targets with FLT_EVAL_METHOD==2.  */
	double kd, z, r, r2, scale, tail, tmp;

	abstop = pow_top12(x) & 0x7ff;
	if (RARELY(abstop - pow_top12(0x1p-54) >=
			  pow_top12(512.0) - pow_top12(0x1p-54))) {
		if (abstop - pow_top12(0x1p-54) >= 0x80000000) {
			/* Avoid spurious underflow for tiny x.  */
			/* Note: 0 is common input.  */
			double one = 1.0 + x;
			return sign_bias ? -one : one;
		}
		if (abstop >= pow_top12(1024.0)) {
			/* Note: inf and nan are already handled.  */
			if (musl_asuint64(x) >> 63)
				return musl_math_uflow(sign_bias);
			else
				return musl_math_oflow(sign_bias);
		}
		/* Large x is special cased below.  */
		abstop = 0;
	}

	/* exp(x) = 2^(k/pow_N) * exp(r), with exp(r) in [2^(-1/2N),2^(1/2N)].  */
	/* x = ln2/pow_N*k + r, with int k and r in [-ln2/2N, ln2/2N].  */
	z = pow_InvLn2N * x;
	/* z - kd is in [-1, 1] in non-nearest rounding modes.  */
	kd = (z + pow_Shift);
	ki = musl_asuint64(kd);
	kd -= pow_Shift;
	r = x + kd * pow_NegLn2hiN + kd * pow_NegLn2loN;
	/* The code assumes 2^-200 < |xtail| < 2^-8/N.  */
	r += xtail;
	/* 2^(k/pow_N) ~= scale * (1 + tail).  */
	idx = 2 * (ki % pow_N);
	top = (ki + sign_bias) << (52 - MUSL_EXP_TABLE_BITS);
	tail = musl_asdouble(pow_T[idx]);
	/* This is only a valid scale when -1023*pow_N < k < 1024*N.  */
	sbits = pow_T[idx + 1] + top;
	/* exp(x) = 2^(k/pow_N) * exp(r) ~= scale + scale * (tail + exp(r) - 1).  */
	/* Evaluation is optimized assuming superscalar pipelined execution.  */
	r2 = r * r;
	/* Without fma the worst case error is 0.25/pow_N ulp larger.  */
	/* Worst case error is less than 0.5+1.11/pow_N+(abs poly error * 2^53) ulp.  */
	tmp = tail + r + r2 * (pow_C2 + r * pow_C3) + r2 * r2 * (pow_C4 + r * pow_C5);
	if (RARELY(abstop == 0))
		return pow_specialcase(tmp, sbits, ki);
	scale = musl_asdouble(sbits);
	/* Note: tmp == 0 or |tmp| > 2^-200 and scale > 2^-739, so there
	   is no spurious underflow here even without fma.  */
	return (scale + scale * tmp);
}

/* Returns 0 if not int, 1 if odd int, 2 if even int.  The argument is
   the bit representation of a non-zero finite floating-point value.  */
static inline int pow_checkint(uint64_t iy)
{
	int e = iy >> 52 & 0x7ff;
	if (e < 0x3ff)
		return 0;
	if (e > 0x3ff + 52)
		return 2;
	if (iy & ((1ULL << (0x3ff + 52 - e)) - 1))
		return 0;
	if (iy & (1ULL << (0x3ff + 52 - e)))
		return 1;
	return 2;
}

/* Returns 1 if input is the bit representation of 0, infinity or nan.  */
static inline int pow_zeroinfnan(uint64_t i)
{
	return 2 * i - 1 >= 2 * musl_asuint64(INFINITY) - 1;
}

static APART double musl_pow(double x, double y)
{
	uint32_t sign_bias = 0;
	uint64_t ix, iy;
	uint32_t topx, topy;

	ix = musl_asuint64(x);
	iy = musl_asuint64(y);
	topx = pow_top12(x);
	topy = pow_top12(y);
	if (RARELY(topx - 0x001 >= 0x7ff - 0x001 ||
			  (topy & 0x7ff) - 0x3be >= 0x43e - 0x3be)) {
		/* Note: if |y| > 1075 * ln2 * 2^53 ~= 0x1.749p62 then pow(x,y) = inf/0
		   and if |y| < 2^-54 / 1075 ~= 0x1.e7b6p-65 then pow(x,y) = +-1.  */
		/* Special cases: (x < 0x1p-126 or inf or nan) or
		   (|y| < 0x1p-65 or |y| >= 0x1p63 or nan).  */
		if (RARELY(pow_zeroinfnan(iy))) {
			if (2 * iy == 0)
				return 1.0;
			if (ix == musl_asuint64(1.0))
				return 1.0;
			if (2 * ix > 2 * musl_asuint64(INFINITY) ||
			    2 * iy > 2 * musl_asuint64(INFINITY))
				return x + y;
			if (2 * ix == 2 * musl_asuint64(1.0))
				return 1.0;
			if ((2 * ix < 2 * musl_asuint64(1.0)) == !(iy >> 63))
				return 0.0; /* |x|<1 && y==inf or |x|>1 && y==-inf.  */
			return y * y;
		}
		if (RARELY(pow_zeroinfnan(ix))) {
			double x2 = x * x;
			if (ix >> 63 && pow_checkint(iy) == 1)
				x2 = -x2;
			/* Without the barrier some versions of clang hoist the 1/x2 and
			   thus division by zero exception can be signaled spuriously.  */
			return iy >> 63 ? (1 / x2) : x2;
		}
		/* Here x and y are non-zero finite.  */
		if (ix >> 63) {
			/* Finite x < 0.  */
			int yint = pow_checkint(iy);
			if (yint == 0)
				return musl_math_invalid(x);
			if (yint == 1)
				sign_bias = pow_SIGN_BIAS;
			ix &= 0x7fffffffffffffff;
			topx &= 0x7ff;
		}
		if ((topy & 0x7ff) - 0x3be >= 0x43e - 0x3be) {
			/* Note: sign_bias == 0 here because y is not odd.  */
			if (ix == musl_asuint64(1.0))
				return 1.0;
			if ((topy & 0x7ff) < 0x3be) {
				/* |y| < 2^-65, x^y ~= 1 + y*log(x).  */
				return ix > musl_asuint64(1.0) ? 1.0 + y : 1.0 - y;
			}
			return (ix > musl_asuint64(1.0)) == (topy < 0x800) ?
				       musl_math_oflow(0) :
				       musl_math_uflow(0);
		}
		if (topx == 0) {
			/* Normalize subnormal x so exponent becomes negative.  */
			ix = musl_asuint64(x * 0x1p52);
			ix &= 0x7fffffffffffffff;
			ix -= 52ULL << 52;
		}
	}

	double lo;
	double hi = pow_log_inline(ix, &lo);
	double ehi, elo;
	double yhi = musl_asdouble(iy & -1ULL << 27);
	double ylo = y - yhi;
	double lhi = musl_asdouble(musl_asuint64(hi) & -1ULL << 27);
	double llo = hi - lhi + lo;
	ehi = yhi * lhi;
	elo = ylo * lhi + y * llo; /* |elo| < |ehi| * 2^-25.  */
	return pow_exp_inline(ehi, elo, sign_bias);
}

/* ---- expm1.c ---- */
/* origin: FreeBSD /usr/src/lib/msun/src/s_expm1.c */
/*
 * ====================================================
 * Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
 *
 * Developed at SunPro, a Sun Microsystems, Inc. business.
 * Permission to use, copy, modify, and distribute this
 * software is freely granted, provided that this notice
 * is preserved.
 * ====================================================
 */
/* expm1(x)
 * Returns exp(x)-1, the exponential of x minus 1.
 *
 * Method
 *   1. Argument reduction:
 *      Given x, find r and integer k such that
 *
 *               x = k*ln2 + r,  |r| <= 0.5*ln2 ~ 0.34658
 *
 *      Here a correction term c will be computed to compensate
 *      the error in r when rounded to a floating-point number.
 *
 *   2. Approximating expm1(r) by a special rational function on
 *      the interval [0,0.34658]:
 *      Since
 *          r*(exp(r)+1)/(exp(r)-1) = 2+ r^2/6 - r^4/360 + ...
 *      we define R1(r*r) by
 *          r*(exp(r)+1)/(exp(r)-1) = 2+ r^2/6 * R1(r*r)
 *      That is,
 *          R1(r**2) = 6/r *((exp(r)+1)/(exp(r)-1) - 2/r)
 *                   = 6/r * ( 1 + 2.0*(1/(exp(r)-1) - 1/r))
 *                   = 1 - r^2/60 + r^4/2520 - r^6/100800 + ...
 *      We use a special Remez algorithm on [0,0.347] to generate
 *      a polynomial of degree 5 in r*r to approximate R1. The
 *      maximum error of this polynomial approximation is bounded
 *      by 2**-61. In other words,
 *          R1(z) ~ 1.0 + expm1_Q1*z + expm1_Q2*z**2 + expm1_Q3*z**3 + expm1_Q4*z**4 + expm1_Q5*z**5
 *      where   expm1_Q1  =  -1.6666666666666567384E-2,
 *              expm1_Q2  =   3.9682539681370365873E-4,
 *              expm1_Q3  =  -9.9206344733435987357E-6,
 *              expm1_Q4  =   2.5051361420808517002E-7,
 *              expm1_Q5  =  -6.2843505682382617102E-9;
 *              z   =  r*r,
 *      with error bounded by
 *          |                  5           |     -61
 *          | 1.0+expm1_Q1*z+...+expm1_Q5*z   -  R1(z) | <= 2
 *          |                              |
 *
 *      expm1(r) = exp(r)-1 is then computed by the following
 *      specific way which minimize the accumulation rounding error:
 *                             2     3
 *                            r     r    [ 3 - (R1 + R1*r/2)  ]
 *            expm1(r) = r + --- + --- * [--------------------]
 *                            2     2    [ 6 - r*(3 - R1*r/2) ]
 *
 *      To compensate the error in the argument reduction, we use
 *              expm1(r+c) = expm1(r) + c + expm1(r)*c
 *                         ~ expm1(r) + c + r*c
 *      Thus c+r*c will be added in as the correction terms for
 *      expm1(r+c). Now rearrange the term to avoid optimization
 *      screw up:
 *                      (      2                                    2 )
 *                      ({  ( r    [ R1 -  (3 - R1*r/2) ]  )  }    r  )
 *       expm1(r+c)~r - ({r*(--- * [--------------------]-c)-c} - --- )
 *                      ({  ( 2    [ 6 - r*(3 - R1*r/2) ]  )  }    2  )
 *                      (                                             )
 *
 *                 = r - E
 *   3. Scale back to obtain expm1(x):
 *      From step 1, we have
 *         expm1(x) = either 2^k*[expm1(r)+1] - 1
 *                  = or     2^k*[expm1(r) + (1-2^-k)]
 *   4. Implementation notes:
 *      (A). To save one multiplication, we scale the coefficient Qi
 *           to Qi*2^i, and replace z by (x^2)/2.
 *      (B). To achieve maximum accuracy, we compute expm1(x) by
 *        (i)   if x < -56*ln2, return -1.0, (raise inexact if x!=inf)
 *        (ii)  if k=0, return r-E
 *        (iii) if k=-1, return 0.5*(r-E)-0.5
 *        (iv)  if k=1 if r < -0.25, return 2*((r+0.5)- E)
 *                     else          return  1.0+2.0*(r-E);
 *        (v)   if (k<-2||k>56) return 2^k(1-(E-r)) - 1 (or exp(x)-1)
 *        (vi)  if k <= 20, return 2^k((1-2^-k)-(E-r)), else
 *        (vii) return 2^k(1-((E+2^-k)-r))
 *
 * Special cases:
 *      expm1(INF) is INF, expm1(NaN) is NaN;
 *      expm1(-INF) is -1, and
 *      for finite argument, only expm1(0)=0 is exact.
 *
 * Accuracy:
 *      according to an error analysis, the error is always less than
 *      1 ulp (unit in the last place).
 *
 * Misc. info.
 *      For IEEE double
 *          if x >  7.09782712893383973096e+02 then expm1(x) overflow
 *
 * Constants:
 * The hexadecimal values are the intended ones for the following
 * constants. The decimal values may be used, provided that the
 * compiler will convert from decimal to binary accurately enough
 * to produce the hexadecimal values shown.
 */


static const double
expm1_o_threshold = 7.09782712893383973096e+02, /* 0x40862E42, 0xFEFA39EF */
expm1_ln2_hi      = 6.93147180369123816490e-01, /* 0x3fe62e42, 0xfee00000 */
expm1_ln2_lo      = 1.90821492927058770002e-10, /* 0x3dea39ef, 0x35793c76 */
expm1_invln2      = 1.44269504088896338700e+00, /* 0x3ff71547, 0x652b82fe */
/* Scaled Q's: Qn_here = 2**n * Qn_above, for R(2*z) where z = hxs = x*x/2: */
expm1_Q1 = -3.33333333333331316428e-02, /* BFA11111 111110F4 */
expm1_Q2 =  1.58730158725481460165e-03, /* 3F5A01A0 19FE5585 */
expm1_Q3 = -7.93650757867487942473e-05, /* BF14CE19 9EAADBB7 */
expm1_Q4 =  4.00821782732936239552e-06, /* 3ED0CFCA 86E65239 */
expm1_Q5 = -2.01099218183624371326e-07; /* BE8AFDB7 6E09C32D */

static APART double musl_expm1(double x)
{
	double y,hi,lo,c,t,e,hxs,hfx,r1,twopk;
	union {double f; uint64_t i;} u = {x};
	uint32_t hx = u.i>>32 & 0x7fffffff;
	int k, sign = u.i>>63;

	/* filter out huge and non-finite argument */
	if (hx >= 0x4043687A) {  /* if |x|>=56*ln2 */
		if (isnan(x))
			return x;
		if (sign)
			return -1;
		if (x > expm1_o_threshold) {
			x *= 0x1p1023;
			return x;
		}
	}

	/* argument reduction */
	if (hx > 0x3fd62e42) {  /* if  |x| > 0.5 ln2 */
		if (hx < 0x3FF0A2B2) {  /* and |x| < 1.5 ln2 */
			if (!sign) {
				hi = x - expm1_ln2_hi;
				lo = expm1_ln2_lo;
				k =  1;
			} else {
				hi = x + expm1_ln2_hi;
				lo = -expm1_ln2_lo;
				k = -1;
			}
		} else {
			k  = expm1_invln2*x + (sign ? -0.5 : 0.5);
			t  = k;
			hi = x - t*expm1_ln2_hi;  /* t*expm1_ln2_hi is exact here */
			lo = t*expm1_ln2_lo;
		}
		x = hi-lo;
		c = (hi-x)-lo;
	} else if (hx < 0x3c900000) {  /* |x| < 2**-54, return x */
		if (hx < 0x00100000)
			;
		return x;
	} else
		k = 0;

	/* x is now in primary range */
	hfx = 0.5*x;
	hxs = x*hfx;
	r1 = 1.0+hxs*(expm1_Q1+hxs*(expm1_Q2+hxs*(expm1_Q3+hxs*(expm1_Q4+hxs*expm1_Q5))));
	t  = 3.0-r1*hfx;
	e  = hxs*((r1-t)/(6.0 - x*t));
	if (k == 0)   /* c is 0 */
		return x - (x*e-hxs);
	e  = x*(e-c) - c;
	e -= hxs;
	/* exp(x) ~ 2^k (x_reduced - e + 1) */
	if (k == -1)
		return 0.5*(x-e) - 0.5;
	if (k == 1) {
		if (x < -0.25)
			return -2.0*(e-(x+0.5));
		return 1.0+2.0*(x-e);
	}
	u.i = (uint64_t)(0x3ff + k)<<52;  /* 2^k */
	twopk = u.f;
	if (k < 0 || k > 56) {  /* suffice to return exp(x)-1 */
		y = x - e + 1.0;
		if (k == 1024)
			y = y*2.0*0x1p1023;
		else
			y = y*twopk;
		return y - 1.0;
	}
	u.i = (uint64_t)(0x3ff - k)<<52;  /* 2^-k */
	if (k < 20)
		y = (x-e+(1-u.f))*twopk;
	else
		y = (x-(e+u.f)+1)*twopk;
	return y;
}

/* ---- __expo2.c ---- */
/* expo2_k is such that expo2_k*ln2 has minimal relative error and x - expo2_kln2 > log(DBL_MIN) */
static const int expo2_k = 2043;
static const double expo2_kln2 = 0x1.62066151add8bp+10;

/* exp(x)/2 for x >= log(DBL_MAX), slightly better than 0.5*exp(x/2)*exp(x/2) */
static double musl_expo2(double x, double sign)
{
	double scale;

	/* note that expo2_k is odd and scale*scale overflows */
	musl_insert_words(scale, (uint32_t)(0x3ff + expo2_k/2) << 20, 0);
	/* exp(x - expo2_k ln2) * 2**(expo2_k-1) */
	/* in directed rounding correct sign before rounding or overflow is important */
	return musl_exp(x - expo2_kln2) * (sign * scale) * scale;
}

/* ---- sinh.c ---- */
/* sinh(x) = (exp(x) - 1/exp(x))/2
 *         = (exp(x)-1 + (exp(x)-1)/exp(x))/2
 *         = x + x^3/6 + o(x^5)
 */
static APART double musl_sinh(double x)
{
	union {double f; uint64_t i;} u = {.f = x};
	uint32_t w;
	double t, h, absx;

	h = 0.5;
	if (u.i >> 63)
		h = -h;
	/* |x| */
	u.i &= (uint64_t)-1/2;
	absx = u.f;
	w = u.i >> 32;

	/* |x| < log(DBL_MAX) */
	if (w < 0x40862e42) {
		t = musl_expm1(absx);
		if (w < 0x3ff00000) {
			if (w < 0x3ff00000 - (26<<20))
				/* note: inexact and underflow are raised by expm1 */
				/* note: this branch avoids spurious underflow */
				return x;
			return h*(2*t - t*t/(t+1));
		}
		/* note: |x|>log(0x1p26)+eps could be just h*exp(x) */
		return h*(t + t/(t+1));
	}

	/* |x| > log(DBL_MAX) or nan */
	/* note: the result is stored to handle overflow */
	t = musl_expo2(absx, 2*h);
	return t;
}

/* ---- cosh.c ---- */
/* cosh(x) = (exp(x) + 1/exp(x))/2
 *         = 1 + 0.5*(exp(x)-1)*(exp(x)-1)/exp(x)
 *         = 1 + x*x/2 + o(x^4)
 */
static APART double musl_cosh(double x)
{
	union {double f; uint64_t i;} u = {.f = x};
	uint32_t w;
	double t;

	/* |x| */
	u.i &= (uint64_t)-1/2;
	x = u.f;
	w = u.i >> 32;

	/* |x| < log(2) */
	if (w < 0x3fe62e42) {
		if (w < 0x3ff00000 - (26<<20)) {
			/* raise inexact if x!=0 */
			;
			return 1;
		}
		t = musl_expm1(x);
		return 1 + t*t/(2*(1+t));
	}

	/* |x| < log(DBL_MAX) */
	if (w < 0x40862e42) {
		t = musl_exp(x);
		/* note: if x>log(0x1p26) then the 1/t is not needed */
		return 0.5*(t + 1/t);
	}

	/* |x| > log(DBL_MAX) or nan */
	/* note: the result is stored to handle overflow */
	t = musl_expo2(x, 1.0);
	return t;
}

/* ---- tanh.c ---- */
/* tanh(x) = (exp(x) - exp(-x))/(exp(x) + exp(-x))
 *         = (exp(2*x) - 1)/(exp(2*x) - 1 + 2)
 *         = (1 - exp(-2*x))/(exp(-2*x) - 1 + 2)
 */
static APART double musl_tanh(double x)
{
	union {double f; uint64_t i;} u = {.f = x};
	uint32_t w;
	int sign;
	double t;

	/* x = |x| */
	sign = u.i >> 63;
	u.i &= (uint64_t)-1/2;
	x = u.f;
	w = u.i >> 32;

	if (w > 0x3fe193ea) {
		/* |x| > log(3)/2 ~= 0.5493 or nan */
		if (w > 0x40340000) {
			/* |x| > 20 or nan */
			/* note: this branch avoids raising overflow */
			t = 1 - 0/x;
		} else {
			t = musl_expm1(2*x);
			t = 1 - 2/(t+2);
		}
	} else if (w > 0x3fd058ae) {
		/* |x| > log(5/3)/2 ~= 0.2554 */
		t = musl_expm1(2*x);
		t = t/(t+2);
	} else if (w >= 0x00100000) {
		/* |x| >= 0x1p-1022, up to 2ulp error in [0.1,0.2554] */
		t = musl_expm1(-2*x);
		t = -t/(t+2);
	} else {
		/* |x| is subnormal */
		/* note: the branch above would not raise underflow in [0x1p-1023,0x1p-1022) */
			;
		t = x;
	}
	return sign ? -t : t;
}
