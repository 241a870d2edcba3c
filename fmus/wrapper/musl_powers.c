/* From musl (https://musl.libc.org, commit 86373b49; its licence is in the documentation's licenses), by the files that are
   named below. Changed: all names are local, with prefixes. Left out: code for fused multiplication and for long double, so
   that the same bits come out everywhere, and comments, which musl's own files have. mathematics.h includes this. */
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

static inline double exp_specialcase(double tmp, uint64_t sbits, uint64_t ki)
{
	double scale, y;

	if ((ki & 0x80000000) == 0) {

		sbits -= 1009ull << 52;
		scale = musl_asdouble(sbits);
		y = 0x1p1009 * (scale + scale * tmp);
		return (y);
	}

	sbits += 1022ull << 52;
	scale = musl_asdouble(sbits);
	y = scale + scale * tmp;
	if (y < 1.0) {

		double hi, lo;
		lo = scale - y + scale * tmp;
		hi = 1.0 + y;
		lo = 1.0 - hi + y + lo;
		y = (hi + lo) - 1.0;

		if (y == 0.0)
			y = 0.0;

	}
	y = 0x1p-1022 * y;
	return (y);
}

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

		abstop = 0;
	}

	z = exp_InvLn2N * x;

	kd = (z + exp_Shift);
	ki = musl_asuint64(kd);
	kd -= exp_Shift;
	r = x + kd * exp_NegLn2hiN + kd * exp_NegLn2loN;

	idx = 2 * (ki % exp_N);
	top = ki << (52 - MUSL_EXP_TABLE_BITS);
	tail = musl_asdouble(exp_T[idx]);

	sbits = exp_T[idx + 1] + top;

	r2 = r * r;

	tmp = tail + r + r2 * (exp_C2 + r * exp_C3) + r2 * r2 * (exp_C4 + r * exp_C5);
	if (RARELY(abstop == 0))
		return exp_specialcase(tmp, sbits, ki);
	scale = musl_asdouble(sbits);

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

		if (RARELY(ix == musl_asuint64(1.0)))
			return 0;
		r = x - 1.0;
		r2 = r * r;
		r3 = r * r2;
		y = r3 *
		    (log_B[1] + r * log_B[2] + r2 * log_B[3] +
		     r3 * (log_B[4] + r * log_B[5] + r2 * log_B[6] +
			   r3 * (log_B[7] + r * log_B[8] + r2 * log_B[9] + r3 * log_B[10])));

		w = r * 0x1p27;
		double rhi = r + w - w;
		double rlo = r - rhi;
		w = rhi * rhi * log_B[0];
		hi = r + w;
		lo = r - hi + w;
		lo += log_B[0] * rlo * (rhi + r);
		y += lo;
		y += hi;
		return (y);
	}
	if (RARELY(top - 0x0010 >= 0x7ff0 - 0x0010)) {

		if (ix * 2 == 0)
			return musl_math_divzero(1);
		if (ix == musl_asuint64(INFINITY))
			return x;
		if ((top & 0x8000) || (top & 0x7ff0) == 0x7ff0)
			return musl_math_invalid(x);

		ix = musl_asuint64(x * 0x1p52);
		ix -= 52ULL << 52;
	}

	tmp = ix - log_OFF;
	i = (tmp >> (52 - MUSL_LOG_TABLE_BITS)) % log_N;
	k = (int64_t)tmp >> 52;
	iz = ix - (tmp & 0xfffULL << 52);
	invc = log_T[i].invc;
	logc = log_T[i].logc;
	z = musl_asdouble(iz);

	r = (z - log_T2[i].chi - log_T2[i].clo) * invc;
	kd = (double)k;

	w = kd * log_Ln2hi + logc;
	hi = w + r;
	lo = w - hi + r + kd * log_Ln2lo;

	r2 = r * r;

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

#define pow_T musl_pow_data.tab
#define pow_A musl_pow_data.poly
#define pow_Ln2hi musl_pow_data.ln2hi
#define pow_Ln2lo musl_pow_data.ln2lo
#define pow_N (1 << MUSL_POW_LOG_TABLE_BITS)
#define pow_OFF 0x3fe6955500000000

static inline uint32_t pow_top12(double x)
{
	return musl_asuint64(x) >> 52;
}

static inline double pow_log_inline(uint64_t ix, double *tail)
{

	double z, r, y, invc, logc, logctail, kd, hi, t1, t2, lo, lo1, lo2, p;
	uint64_t iz, tmp;
	int k, i;

	tmp = ix - pow_OFF;
	i = (tmp >> (52 - MUSL_POW_LOG_TABLE_BITS)) % pow_N;
	k = (int64_t)tmp >> 52;
	iz = ix - (tmp & 0xfffULL << 52);
	z = musl_asdouble(iz);
	kd = (double)k;

	invc = pow_T[i].invc;
	logc = pow_T[i].logc;
	logctail = pow_T[i].logctail;

	double zhi = musl_asdouble((iz + (1ULL << 31)) & (-1ULL << 32));
	double zlo = z - zhi;
	double rhi = zhi * invc - 1.0;
	double rlo = zlo * invc;
	r = rhi + rlo;

	t1 = kd * pow_Ln2hi + logc;
	t2 = t1 + r;
	lo1 = kd * pow_Ln2lo + logctail;
	lo2 = t1 - t2 + r;

	double ar, ar2, ar3, lo3, lo4;
	ar = pow_A[0] * r;
	ar2 = r * ar;
	ar3 = r * ar2;

	double arhi = pow_A[0] * rhi;
	double arhi2 = rhi * arhi;
	hi = t2 + arhi2;
	lo3 = rlo * (ar + arhi);
	lo4 = t2 - hi + arhi2;

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

static inline double pow_specialcase(double tmp, uint64_t sbits, uint64_t ki)
{
	double scale, y;

	if ((ki & 0x80000000) == 0) {

		sbits -= 1009ull << 52;
		scale = musl_asdouble(sbits);
		y = 0x1p1009 * (scale + scale * tmp);
		return (y);
	}

	sbits += 1022ull << 52;

	scale = musl_asdouble(sbits);
	y = scale + scale * tmp;
	if (fabs(y) < 1.0) {

		double hi, lo, one = 1.0;
		if (y < 0.0)
			one = -1.0;
		lo = scale - y + scale * tmp;
		hi = one + y;
		lo = one - hi + y + lo;
		y = (hi + lo) - one;

		if (y == 0.0)
			y = musl_asdouble(sbits & 0x8000000000000000);

	}
	y = 0x1p-1022 * y;
	return (y);
}

#define pow_SIGN_BIAS (0x800 << MUSL_EXP_TABLE_BITS)

static inline double pow_exp_inline(double x, double xtail, uint32_t sign_bias)
{
	uint32_t abstop;
	uint64_t ki, idx, top, sbits;

	double kd, z, r, r2, scale, tail, tmp;

	abstop = pow_top12(x) & 0x7ff;
	if (RARELY(abstop - pow_top12(0x1p-54) >=
			  pow_top12(512.0) - pow_top12(0x1p-54))) {
		if (abstop - pow_top12(0x1p-54) >= 0x80000000) {

			double one = 1.0 + x;
			return sign_bias ? -one : one;
		}
		if (abstop >= pow_top12(1024.0)) {

			if (musl_asuint64(x) >> 63)
				return musl_math_uflow(sign_bias);
			else
				return musl_math_oflow(sign_bias);
		}

		abstop = 0;
	}

	z = pow_InvLn2N * x;

	kd = (z + pow_Shift);
	ki = musl_asuint64(kd);
	kd -= pow_Shift;
	r = x + kd * pow_NegLn2hiN + kd * pow_NegLn2loN;

	r += xtail;

	idx = 2 * (ki % pow_N);
	top = (ki + sign_bias) << (52 - MUSL_EXP_TABLE_BITS);
	tail = musl_asdouble(pow_T[idx]);

	sbits = pow_T[idx + 1] + top;

	r2 = r * r;

	tmp = tail + r + r2 * (pow_C2 + r * pow_C3) + r2 * r2 * (pow_C4 + r * pow_C5);
	if (RARELY(abstop == 0))
		return pow_specialcase(tmp, sbits, ki);
	scale = musl_asdouble(sbits);

	return (scale + scale * tmp);
}

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
				return 0.0;
			return y * y;
		}
		if (RARELY(pow_zeroinfnan(ix))) {
			double x2 = x * x;
			if (ix >> 63 && pow_checkint(iy) == 1)
				x2 = -x2;

			return iy >> 63 ? (1 / x2) : x2;
		}

		if (ix >> 63) {

			int yint = pow_checkint(iy);
			if (yint == 0)
				return musl_math_invalid(x);
			if (yint == 1)
				sign_bias = pow_SIGN_BIAS;
			ix &= 0x7fffffffffffffff;
			topx &= 0x7ff;
		}
		if ((topy & 0x7ff) - 0x3be >= 0x43e - 0x3be) {

			if (ix == musl_asuint64(1.0))
				return 1.0;
			if ((topy & 0x7ff) < 0x3be) {

				return ix > musl_asuint64(1.0) ? 1.0 + y : 1.0 - y;
			}
			return (ix > musl_asuint64(1.0)) == (topy < 0x800) ?
				       musl_math_oflow(0) :
				       musl_math_uflow(0);
		}
		if (topx == 0) {

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
	elo = ylo * lhi + y * llo;
	return pow_exp_inline(ehi, elo, sign_bias);
}

/* ---- expm1.c ---- */

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

static const double
expm1_o_threshold = 7.09782712893383973096e+02,
expm1_ln2_hi      = 6.93147180369123816490e-01,
expm1_ln2_lo      = 1.90821492927058770002e-10,
expm1_invln2      = 1.44269504088896338700e+00,

expm1_Q1 = -3.33333333333331316428e-02,
expm1_Q2 =  1.58730158725481460165e-03,
expm1_Q3 = -7.93650757867487942473e-05,
expm1_Q4 =  4.00821782732936239552e-06,
expm1_Q5 = -2.01099218183624371326e-07;

static APART double musl_expm1(double x)
{
	double y,hi,lo,c,t,e,hxs,hfx,r1,twopk;
	union {double f; uint64_t i;} u = {x};
	uint32_t hx = u.i>>32 & 0x7fffffff;
	int k, sign = u.i>>63;

	if (hx >= 0x4043687A) {
		if (isnan(x))
			return x;
		if (sign)
			return -1;
		if (x > expm1_o_threshold) {
			x *= 0x1p1023;
			return x;
		}
	}

	if (hx > 0x3fd62e42) {
		if (hx < 0x3FF0A2B2) {
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
			hi = x - t*expm1_ln2_hi;
			lo = t*expm1_ln2_lo;
		}
		x = hi-lo;
		c = (hi-x)-lo;
	} else if (hx < 0x3c900000) {
		if (hx < 0x00100000)
			;
		return x;
	} else
		k = 0;

	hfx = 0.5*x;
	hxs = x*hfx;
	r1 = 1.0+hxs*(expm1_Q1+hxs*(expm1_Q2+hxs*(expm1_Q3+hxs*(expm1_Q4+hxs*expm1_Q5))));
	t  = 3.0-r1*hfx;
	e  = hxs*((r1-t)/(6.0 - x*t));
	if (k == 0)
		return x - (x*e-hxs);
	e  = x*(e-c) - c;
	e -= hxs;

	if (k == -1)
		return 0.5*(x-e) - 0.5;
	if (k == 1) {
		if (x < -0.25)
			return -2.0*(e-(x+0.5));
		return 1.0+2.0*(x-e);
	}
	u.i = (uint64_t)(0x3ff + k)<<52;
	twopk = u.f;
	if (k < 0 || k > 56) {
		y = x - e + 1.0;
		if (k == 1024)
			y = y*2.0*0x1p1023;
		else
			y = y*twopk;
		return y - 1.0;
	}
	u.i = (uint64_t)(0x3ff - k)<<52;
	if (k < 20)
		y = (x-e+(1-u.f))*twopk;
	else
		y = (x-(e+u.f)+1)*twopk;
	return y;
}

/* ---- __expo2.c ---- */

static const int expo2_k = 2043;
static const double expo2_kln2 = 0x1.62066151add8bp+10;

static double musl_expo2(double x, double sign)
{
	double scale;

	musl_insert_words(scale, (uint32_t)(0x3ff + expo2_k/2) << 20, 0);

	return musl_exp(x - expo2_kln2) * (sign * scale) * scale;
}

/* ---- sinh.c ---- */

static APART double musl_sinh(double x)
{
	union {double f; uint64_t i;} u = {.f = x};
	uint32_t w;
	double t, h, absx;

	h = 0.5;
	if (u.i >> 63)
		h = -h;

	u.i &= (uint64_t)-1/2;
	absx = u.f;
	w = u.i >> 32;

	if (w < 0x40862e42) {
		t = musl_expm1(absx);
		if (w < 0x3ff00000) {
			if (w < 0x3ff00000 - (26<<20))

				return x;
			return h*(2*t - t*t/(t+1));
		}

		return h*(t + t/(t+1));
	}

	t = musl_expo2(absx, 2*h);
	return t;
}

/* ---- cosh.c ---- */

static APART double musl_cosh(double x)
{
	union {double f; uint64_t i;} u = {.f = x};
	uint32_t w;
	double t;

	u.i &= (uint64_t)-1/2;
	x = u.f;
	w = u.i >> 32;

	if (w < 0x3fe62e42) {
		if (w < 0x3ff00000 - (26<<20)) {

			;
			return 1;
		}
		t = musl_expm1(x);
		return 1 + t*t/(2*(1+t));
	}

	if (w < 0x40862e42) {
		t = musl_exp(x);

		return 0.5*(t + 1/t);
	}

	t = musl_expo2(x, 1.0);
	return t;
}

/* ---- tanh.c ---- */

static APART double musl_tanh(double x)
{
	union {double f; uint64_t i;} u = {.f = x};
	uint32_t w;
	int sign;
	double t;

	sign = u.i >> 63;
	u.i &= (uint64_t)-1/2;
	x = u.f;
	w = u.i >> 32;

	if (w > 0x3fe193ea) {

		if (w > 0x40340000) {

			t = 1 - 0/x;
		} else {
			t = musl_expm1(2*x);
			t = 1 - 2/(t+2);
		}
	} else if (w > 0x3fd058ae) {

		t = musl_expm1(2*x);
		t = t/(t+2);
	} else if (w >= 0x00100000) {

		t = musl_expm1(-2*x);
		t = -t/(t+2);
	} else {

			;
		t = x;
	}
	return sign ? -t : t;
}
