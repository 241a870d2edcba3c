/* From musl (https://musl.libc.org, commit 86373b49; its licence is in the documentation's licenses), by the files that are
   named below. Changed: all names are local, with prefixes. Left out: code for fused multiplication and for long double, so
   that the same bits come out everywhere, and comments, which musl's own files have. mathematics.h includes this. */
#pragma GCC system_header

/* ---- __rem_pio2_large.c ---- */

/*
 * ====================================================
 * Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
 *
 * Developed at SunSoft, a Sun Microsystems, Inc. business.
 * Permission to use, copy, modify, and distribute this
 * software is freely granted, provided that this notice
 * is preserved.
 * ====================================================
 */

static const int reduce_init_jk[] = {3,4,4,6};

static const int32_t reduce_ipio2[] = {
0xA2F983, 0x6E4E44, 0x1529FC, 0x2757D1, 0xF534DD, 0xC0DB62,
0x95993C, 0x439041, 0xFE5163, 0xABDEBB, 0xC561B7, 0x246E3A,
0x424DD2, 0xE00649, 0x2EEA09, 0xD1921C, 0xFE1DEB, 0x1CB129,
0xA73EE8, 0x8235F5, 0x2EBB44, 0x84E99C, 0x7026B4, 0x5F7E41,
0x3991D6, 0x398353, 0x39F49C, 0x845F8B, 0xBDF928, 0x3B1FF8,
0x97FFDE, 0x05980F, 0xEF2F11, 0x8B5A0A, 0x6D1F6D, 0x367ECF,
0x27CB09, 0xB74F46, 0x3F669E, 0x5FEA2D, 0x7527BA, 0xC7EBE5,
0xF17B3D, 0x0739F7, 0x8A5292, 0xEA6BFB, 0x5FB11F, 0x8D5D08,
0x560330, 0x46FC7B, 0x6BABF0, 0xCFBC20, 0x9AF436, 0x1DA9E3,
0x91615E, 0xE61B08, 0x659985, 0x5F14A0, 0x68408D, 0xFFD880,
0x4D7327, 0x310606, 0x1556CA, 0x73A8C9, 0x60E27B, 0xC08C6B,

};

static const double reduce_PIo2[] = {
  1.57079625129699707031e+00,
  7.54978941586159635335e-08,
  5.39030252995776476554e-15,
  3.28200341580791294123e-22,
  1.27065575308067607349e-29,
  1.22933308981111328932e-36,
  2.73370053816464559624e-44,
  2.16741683877804819444e-51,
};

static APART int musl_rem_pio2_large(double *x, double *y, int e0, int nx, int prec)
{
	int32_t jz,jx,jv,jp,jk,carry,n,iq[20],i,j,k,m,q0,ih;
	double z,fw,f[20],fq[20],q[20];

	jk = reduce_init_jk[prec];
	jp = jk;

	jx = nx-1;
	jv = (e0-3)/24;  if(jv<0) jv=0;
	q0 = e0-24*(jv+1);

	j = jv-jx; m = jx+jk;
	for (i=0; i<=m; i++,j++)
		f[i] = j<0 ? 0.0 : (double)reduce_ipio2[j];

	for (i=0; i<=jk; i++) {
		for (j=0,fw=0.0; j<=jx; j++)
			fw += x[j]*f[jx+i-j];
		q[i] = fw;
	}

	jz = jk;
recompute:

	for (i=0,j=jz,z=q[jz]; j>0; i++,j--) {
		fw    = (double)(int32_t)(0x1p-24*z);
		iq[i] = (int32_t)(z - 0x1p24*fw);
		z     = q[j-1]+fw;
	}

	z  = musl_scale(z,q0);
	z -= 8.0*floor(z*0.125);
	n  = (int32_t)z;
	z -= (double)n;
	ih = 0;
	if (q0 > 0) {
		i  = iq[jz-1]>>(24-q0); n += i;
		iq[jz-1] -= i<<(24-q0);
		ih = iq[jz-1]>>(23-q0);
	}
	else if (q0 == 0) ih = iq[jz-1]>>23;
	else if (z >= 0.5) ih = 2;

	if (ih > 0) {
		n += 1; carry = 0;
		for (i=0; i<jz; i++) {
			j = iq[i];
			if (carry == 0) {
				if (j != 0) {
					carry = 1;
					iq[i] = 0x1000000 - j;
				}
			} else
				iq[i] = 0xffffff - j;
		}
		if (q0 > 0) {
			switch(q0) {
			case 1:
				iq[jz-1] &= 0x7fffff; break;
			case 2:
				iq[jz-1] &= 0x3fffff; break;
			}
		}
		if (ih == 2) {
			z = 1.0 - z;
			if (carry != 0)
				z -= musl_scale(1.0,q0);
		}
	}

	if (z == 0.0) {
		j = 0;
		for (i=jz-1; i>=jk; i--) j |= iq[i];
		if (j == 0) {
			for (k=1; iq[jk-k]==0; k++);

			for (i=jz+1; i<=jz+k; i++) {
				f[jx+i] = (double)reduce_ipio2[jv+i];
				for (j=0,fw=0.0; j<=jx; j++)
					fw += x[j]*f[jx+i-j];
				q[i] = fw;
			}
			jz += k;
			goto recompute;
		}
	}

	if (z == 0.0) {
		jz -= 1;
		q0 -= 24;
		while (iq[jz] == 0) {
			jz--;
			q0 -= 24;
		}
	} else {
		z = musl_scale(z,-q0);
		if (z >= 0x1p24) {
			fw = (double)(int32_t)(0x1p-24*z);
			iq[jz] = (int32_t)(z - 0x1p24*fw);
			jz += 1;
			q0 += 24;
			iq[jz] = (int32_t)fw;
		} else
			iq[jz] = (int32_t)z;
	}

	fw = musl_scale(1.0,q0);
	for (i=jz; i>=0; i--) {
		q[i] = fw*(double)iq[i];
		fw *= 0x1p-24;
	}

	for(i=jz; i>=0; i--) {
		for (fw=0.0,k=0; k<=jp && k<=jz-i; k++)
			fw += reduce_PIo2[k]*q[i+k];
		fq[jz-i] = fw;
	}

	switch(prec) {
	case 0:
		fw = 0.0;
		for (i=jz; i>=0; i--)
			fw += fq[i];
		y[0] = ih==0 ? fw : -fw;
		break;
	case 1:
	case 2:
		fw = 0.0;
		for (i=jz; i>=0; i--)
			fw += fq[i];

		fw = (double)fw;
		y[0] = ih==0 ? fw : -fw;
		fw = fq[0]-fw;
		for (i=1; i<=jz; i++)
			fw += fq[i];
		y[1] = ih==0 ? fw : -fw;
		break;
	case 3:
		for (i=jz; i>0; i--) {
			fw      = fq[i-1]+fq[i];
			fq[i]  += fq[i-1]-fw;
			fq[i-1] = fw;
		}
		for (i=jz; i>1; i--) {
			fw      = fq[i-1]+fq[i];
			fq[i]  += fq[i-1]-fw;
			fq[i-1] = fw;
		}
		for (fw=0.0,i=jz; i>=2; i--)
			fw += fq[i];
		if (ih==0) {
			y[0] =  fq[0]; y[1] =  fq[1]; y[2] =  fw;
		} else {
			y[0] = -fq[0]; y[1] = -fq[1]; y[2] = -fw;
		}
	}
	return n&7;
}

/* ---- __rem_pio2.c ---- */

/*
 * ====================================================
 * Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
 *
 * Developed at SunSoft, a Sun Microsystems, Inc. business.
 * Permission to use, copy, modify, and distribute this
 * software is freely granted, provided that this notice
 * is preserved.
 * ====================================================
 *
 * Optimized by Bruce D. Evans.
 */

#define reduction_EPS DBL_EPSILON

static const double
reduction_toint   = 1.5/reduction_EPS,
reduction_pio4    = 0x1.921fb54442d18p-1,
reduction_invpio2 = 6.36619772367581382433e-01,
reduction_pio2_1  = 1.57079632673412561417e+00,
reduction_pio2_1t = 6.07710050650619224932e-11,
reduction_pio2_2  = 6.07710050630396597660e-11,
reduction_pio2_2t = 2.02226624879595063154e-21,
reduction_pio2_3  = 2.02226624871116645580e-21,
reduction_pio2_3t = 8.47842766036889956997e-32;

static APART int musl_rem_pio2(double x, double *y)
{
	union {double f; uint64_t i;} u = {x};
	double z,w,t,r,fn;
	double tx[3],ty[2];
	uint32_t ix;
	int sign, n, ex, ey, i;

	sign = u.i>>63;
	ix = u.i>>32 & 0x7fffffff;
	if (ix <= 0x400f6a7a) {
		if ((ix & 0xfffff) == 0x921fb)
			goto medium;
		if (ix <= 0x4002d97c) {
			if (!sign) {
				z = x - reduction_pio2_1;
				y[0] = z - reduction_pio2_1t;
				y[1] = (z-y[0]) - reduction_pio2_1t;
				return 1;
			} else {
				z = x + reduction_pio2_1;
				y[0] = z + reduction_pio2_1t;
				y[1] = (z-y[0]) + reduction_pio2_1t;
				return -1;
			}
		} else {
			if (!sign) {
				z = x - 2*reduction_pio2_1;
				y[0] = z - 2*reduction_pio2_1t;
				y[1] = (z-y[0]) - 2*reduction_pio2_1t;
				return 2;
			} else {
				z = x + 2*reduction_pio2_1;
				y[0] = z + 2*reduction_pio2_1t;
				y[1] = (z-y[0]) + 2*reduction_pio2_1t;
				return -2;
			}
		}
	}
	if (ix <= 0x401c463b) {
		if (ix <= 0x4015fdbc) {
			if (ix == 0x4012d97c)
				goto medium;
			if (!sign) {
				z = x - 3*reduction_pio2_1;
				y[0] = z - 3*reduction_pio2_1t;
				y[1] = (z-y[0]) - 3*reduction_pio2_1t;
				return 3;
			} else {
				z = x + 3*reduction_pio2_1;
				y[0] = z + 3*reduction_pio2_1t;
				y[1] = (z-y[0]) + 3*reduction_pio2_1t;
				return -3;
			}
		} else {
			if (ix == 0x401921fb)
				goto medium;
			if (!sign) {
				z = x - 4*reduction_pio2_1;
				y[0] = z - 4*reduction_pio2_1t;
				y[1] = (z-y[0]) - 4*reduction_pio2_1t;
				return 4;
			} else {
				z = x + 4*reduction_pio2_1;
				y[0] = z + 4*reduction_pio2_1t;
				y[1] = (z-y[0]) + 4*reduction_pio2_1t;
				return -4;
			}
		}
	}
	if (ix < 0x413921fb) {
medium:

		fn = (double)x*reduction_invpio2 + reduction_toint - reduction_toint;
		n = (int32_t)fn;
		r = x - fn*reduction_pio2_1;
		w = fn*reduction_pio2_1t;

		if (RARELY(r - w < -reduction_pio4)) {
			n--;
			fn--;
			r = x - fn*reduction_pio2_1;
			w = fn*reduction_pio2_1t;
		} else if (RARELY(r - w > reduction_pio4)) {
			n++;
			fn++;
			r = x - fn*reduction_pio2_1;
			w = fn*reduction_pio2_1t;
		}
		y[0] = r - w;
		u.f = y[0];
		ey = u.i>>52 & 0x7ff;
		ex = ix>>20;
		if (ex - ey > 16) {
			t = r;
			w = fn*reduction_pio2_2;
			r = t - w;
			w = fn*reduction_pio2_2t - ((t-r)-w);
			y[0] = r - w;
			u.f = y[0];
			ey = u.i>>52 & 0x7ff;
			if (ex - ey > 49) {
				t = r;
				w = fn*reduction_pio2_3;
				r = t - w;
				w = fn*reduction_pio2_3t - ((t-r)-w);
				y[0] = r - w;
			}
		}
		y[1] = (r - y[0]) - w;
		return n;
	}

	if (ix >= 0x7ff00000) {
		y[0] = y[1] = x - x;
		return 0;
	}

	u.f = x;
	u.i &= (uint64_t)-1>>12;
	u.i |= (uint64_t)(0x3ff + 23)<<52;
	z = u.f;
	for (i=0; i < 2; i++) {
		tx[i] = (double)(int32_t)z;
		z     = (z-tx[i])*0x1p24;
	}
	tx[i] = z;

	while (tx[i] == 0.0)
		i--;
	n = musl_rem_pio2_large(tx,ty,(int)(ix>>20)-(0x3ff+23),i+1,1);
	if (sign) {
		y[0] = -ty[0];
		y[1] = -ty[1];
		return -n;
	}
	y[0] = ty[0];
	y[1] = ty[1];
	return n;
}

/* ---- __sin.c ---- */

/*
 * ====================================================
 * Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
 *
 * Developed at SunSoft, a Sun Microsystems, Inc. business.
 * Permission to use, copy, modify, and distribute this
 * software is freely granted, provided that this notice
 * is preserved.
 * ====================================================
 */

static const double
ksin_S1  = -1.66666666666666324348e-01,
ksin_S2  =  8.33333333332248946124e-03,
ksin_S3  = -1.98412698298579493134e-04,
ksin_S4  =  2.75573137070700676789e-06,
ksin_S5  = -2.50507602534068634195e-08,
ksin_S6  =  1.58969099521155010221e-10;

static double musl_kernel_sin(double x, double y, int iy)
{
	double z,r,v,w;

	z = x*x;
	w = z*z;
	r = ksin_S2 + z*(ksin_S3 + z*ksin_S4) + z*w*(ksin_S5 + z*ksin_S6);
	v = z*x;
	if (iy == 0)
		return x + v*(ksin_S1 + z*r);
	else
		return x - ((z*(0.5*y - v*r) - y) - v*ksin_S1);
}

/* ---- __cos.c ---- */

/*
 * ====================================================
 * Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
 *
 * Developed at SunSoft, a Sun Microsystems, Inc. business.
 * Permission to use, copy, modify, and distribute this
 * software is freely granted, provided that this notice
 * is preserved.
 * ====================================================
 */

static const double
kcos_C1  =  4.16666666666666019037e-02,
kcos_C2  = -1.38888888888741095749e-03,
kcos_C3  =  2.48015872894767294178e-05,
kcos_C4  = -2.75573143513906633035e-07,
kcos_C5  =  2.08757232129817482790e-09,
kcos_C6  = -1.13596475577881948265e-11;

static double musl_kernel_cos(double x, double y)
{
	double hz,z,r,w;

	z  = x*x;
	w  = z*z;
	r  = z*(kcos_C1+z*(kcos_C2+z*kcos_C3)) + w*w*(kcos_C4+z*(kcos_C5+z*kcos_C6));
	hz = 0.5*z;
	w  = 1.0-hz;
	return w + (((1.0-w)-hz) + (z*r-x*y));
}

/* ---- __tan.c ---- */

/*
 * ====================================================
 * Copyright 2004 Sun Microsystems, Inc.  All Rights Reserved.
 *
 * Permission to use, copy, modify, and distribute this
 * software is freely granted, provided that this notice
 * is preserved.
 * ====================================================
 */

static const double ktan_T[] = {
             3.33333333333334091986e-01,
             1.33333333333201242699e-01,
             5.39682539762260521377e-02,
             2.18694882948595424599e-02,
             8.86323982359930005737e-03,
             3.59207910759131235356e-03,
             1.45620945432529025516e-03,
             5.88041240820264096874e-04,
             2.46463134818469906812e-04,
             7.81794442939557092300e-05,
             7.14072491382608190305e-05,
            -1.85586374855275456654e-05,
             2.59073051863633712884e-05,
},
ktan_pio4 =       7.85398163397448278999e-01,
ktan_pio4lo =     3.06161699786838301793e-17;

static double musl_kernel_tan(double x, double y, int odd)
{
	double z, r, v, w, s, a;
	double w0, a0;
	uint32_t hx;
	int big, sign;

	musl_get_high_word(hx,x);
	big = (hx&0x7fffffff) >= 0x3FE59428;
	if (big) {
		sign = hx>>31;
		if (sign) {
			x = -x;
			y = -y;
		}
		x = (ktan_pio4 - x) + (ktan_pio4lo - y);
		y = 0.0;
	}
	z = x * x;
	w = z * z;

	r = ktan_T[1] + w*(ktan_T[3] + w*(ktan_T[5] + w*(ktan_T[7] + w*(ktan_T[9] + w*ktan_T[11]))));
	v = z*(ktan_T[2] + w*(ktan_T[4] + w*(ktan_T[6] + w*(ktan_T[8] + w*(ktan_T[10] + w*ktan_T[12])))));
	s = z * x;
	r = y + z*(s*(r + v) + y) + s*ktan_T[0];
	w = x + r;
	if (big) {
		s = 1 - 2*odd;
		v = s - 2.0 * (x + (r - w*w/(w + s)));
		return sign ? -v : v;
	}
	if (!odd)
		return w;

	w0 = w;
	musl_set_low_word(w0, 0);
	v = r - (w0 - x);
	a0 = a = -1.0 / w;
	musl_set_low_word(a0, 0);
	return a0 + a*(1.0 + a0*w0 + a0*v);
}

/* ---- sin.c ---- */

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

static APART double musl_sin(double x)
{
	double y[2];
	uint32_t ix;
	unsigned n;

	musl_get_high_word(ix, x);
	ix &= 0x7fffffff;

	if (ix <= 0x3fe921fb) {
		if (ix < 0x3e500000) {

			;
			return x;
		}
		return musl_kernel_sin(x, 0.0, 0);
	}

	if (ix >= 0x7ff00000)
		return x - x;

	n = musl_rem_pio2(x, y);
	switch (n&3) {
	case 0: return  musl_kernel_sin(y[0], y[1], 1);
	case 1: return  musl_kernel_cos(y[0], y[1]);
	case 2: return -musl_kernel_sin(y[0], y[1], 1);
	default:
		return -musl_kernel_cos(y[0], y[1]);
	}
}

/* ---- cos.c ---- */

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

static APART double musl_cos(double x)
{
	double y[2];
	uint32_t ix;
	unsigned n;

	musl_get_high_word(ix, x);
	ix &= 0x7fffffff;

	if (ix <= 0x3fe921fb) {
		if (ix < 0x3e46a09e) {

			;
			return 1.0;
		}
		return musl_kernel_cos(x, 0);
	}

	if (ix >= 0x7ff00000)
		return x-x;

	n = musl_rem_pio2(x, y);
	switch (n&3) {
	case 0: return  musl_kernel_cos(y[0], y[1]);
	case 1: return -musl_kernel_sin(y[0], y[1], 1);
	case 2: return -musl_kernel_cos(y[0], y[1]);
	default:
		return  musl_kernel_sin(y[0], y[1], 1);
	}
}

/* ---- tan.c ---- */

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

static APART double musl_tan(double x)
{
	double y[2];
	uint32_t ix;
	unsigned n;

	musl_get_high_word(ix, x);
	ix &= 0x7fffffff;

	if (ix <= 0x3fe921fb) {
		if (ix < 0x3e400000) {

			;
			return x;
		}
		return musl_kernel_tan(x, 0.0, 0);
	}

	if (ix >= 0x7ff00000)
		return x - x;

	n = musl_rem_pio2(x, y);
	return musl_kernel_tan(y[0], y[1], n&1);
}

/* ---- asin.c ---- */

/*
 * ====================================================
 * Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
 *
 * Developed at SunSoft, a Sun Microsystems, Inc. business.
 * Permission to use, copy, modify, and distribute this
 * software is freely granted, provided that this notice
 * is preserved.
 * ====================================================
 */

static const double
asin_pio2_hi = 1.57079632679489655800e+00,
asin_pio2_lo = 6.12323399573676603587e-17,

asin_pS0 =  1.66666666666666657415e-01,
asin_pS1 = -3.25565818622400915405e-01,
asin_pS2 =  2.01212532134862925881e-01,
asin_pS3 = -4.00555345006794114027e-02,
asin_pS4 =  7.91534994289814532176e-04,
asin_pS5 =  3.47933107596021167570e-05,
asin_qS1 = -2.40339491173441421878e+00,
asin_qS2 =  2.02094576023350569471e+00,
asin_qS3 = -6.88283971605453293030e-01,
asin_qS4 =  7.70381505559019352791e-02;

static double asin_R(double z)
{
	double p, q;
	p = z*(asin_pS0+z*(asin_pS1+z*(asin_pS2+z*(asin_pS3+z*(asin_pS4+z*asin_pS5)))));
	q = 1.0+z*(asin_qS1+z*(asin_qS2+z*(asin_qS3+z*asin_qS4)));
	return p/q;
}

static APART double musl_asin(double x)
{
	double z,r,s;
	uint32_t hx,ix;

	musl_get_high_word(hx, x);
	ix = hx & 0x7fffffff;

	if (ix >= 0x3ff00000) {
		uint32_t lx;
		musl_get_low_word(lx, x);
		if ((ix-0x3ff00000 | lx) == 0)

			return x*asin_pio2_hi + 0x1p-120f;
		return 0/(x-x);
	}

	if (ix < 0x3fe00000) {

		if (ix < 0x3e500000 && ix >= 0x00100000)
			return x;
		return x + x*asin_R(x*x);
	}

	z = (1 - fabs(x))*0.5;
	s = sqrt(z);
	r = asin_R(z);
	if (ix >= 0x3fef3333) {
		x = asin_pio2_hi-(2*(s+s*r)-asin_pio2_lo);
	} else {
		double f,c;

		f = s;
		musl_set_low_word(f,0);
		c = (z-f*f)/(s+f);
		x = 0.5*asin_pio2_hi - (2*s*r - (asin_pio2_lo-2*c) - (0.5*asin_pio2_hi-2*f));
	}
	if (hx >> 31)
		return -x;
	return x;
}

/* ---- acos.c ---- */

/*
 * ====================================================
 * Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
 *
 * Developed at SunSoft, a Sun Microsystems, Inc. business.
 * Permission to use, copy, modify, and distribute this
 * software is freely granted, provided that this notice
 * is preserved.
 * ====================================================
 */

static const double
acos_pio2_hi = 1.57079632679489655800e+00,
acos_pio2_lo = 6.12323399573676603587e-17,
acos_pS0 =  1.66666666666666657415e-01,
acos_pS1 = -3.25565818622400915405e-01,
acos_pS2 =  2.01212532134862925881e-01,
acos_pS3 = -4.00555345006794114027e-02,
acos_pS4 =  7.91534994289814532176e-04,
acos_pS5 =  3.47933107596021167570e-05,
acos_qS1 = -2.40339491173441421878e+00,
acos_qS2 =  2.02094576023350569471e+00,
acos_qS3 = -6.88283971605453293030e-01,
acos_qS4 =  7.70381505559019352791e-02;

static double acos_R(double z)
{
	double p, q;
	p = z*(acos_pS0+z*(acos_pS1+z*(acos_pS2+z*(acos_pS3+z*(acos_pS4+z*acos_pS5)))));
	q = 1.0+z*(acos_qS1+z*(acos_qS2+z*(acos_qS3+z*acos_qS4)));
	return p/q;
}

static APART double musl_acos(double x)
{
	double z,w,s,c,df;
	uint32_t hx,ix;

	musl_get_high_word(hx, x);
	ix = hx & 0x7fffffff;

	if (ix >= 0x3ff00000) {
		uint32_t lx;

		musl_get_low_word(lx,x);
		if ((ix-0x3ff00000 | lx) == 0) {

			if (hx >> 31)
				return 2*acos_pio2_hi + 0x1p-120f;
			return 0;
		}
		return 0/(x-x);
	}

	if (ix < 0x3fe00000) {
		if (ix <= 0x3c600000)
			return acos_pio2_hi + 0x1p-120f;
		return acos_pio2_hi - (x - (acos_pio2_lo-x*acos_R(x*x)));
	}

	if (hx >> 31) {
		z = (1.0+x)*0.5;
		s = sqrt(z);
		w = acos_R(z)*s-acos_pio2_lo;
		return 2*(acos_pio2_hi - (s+w));
	}

	z = (1.0-x)*0.5;
	s = sqrt(z);
	df = s;
	musl_set_low_word(df,0);
	c = (z-df*df)/(s+df);
	w = acos_R(z)*s+c;
	return 2*(df+w);
}

/* ---- atan.c ---- */

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

static const double atan_atanhi[] = {
  4.63647609000806093515e-01,
  7.85398163397448278999e-01,
  9.82793723247329054082e-01,
  1.57079632679489655800e+00,
};

static const double atan_atanlo[] = {
  2.26987774529616870924e-17,
  3.06161699786838301793e-17,
  1.39033110312309984516e-17,
  6.12323399573676603587e-17,
};

static const double atan_aT[] = {
  3.33333333333329318027e-01,
 -1.99999999998764832476e-01,
  1.42857142725034663711e-01,
 -1.11111104054623557880e-01,
  9.09088713343650656196e-02,
 -7.69187620504482999495e-02,
  6.66107313738753120669e-02,
 -5.83357013379057348645e-02,
  4.97687799461593236017e-02,
 -3.65315727442169155270e-02,
  1.62858201153657823623e-02,
};

static APART double musl_atan(double x)
{
	double w,s1,s2,z;
	uint32_t ix,sign;
	int id;

	musl_get_high_word(ix, x);
	sign = ix >> 31;
	ix &= 0x7fffffff;
	if (ix >= 0x44100000) {
		if (isnan(x))
			return x;
		z = atan_atanhi[3] + 0x1p-120f;
		return sign ? -z : z;
	}
	if (ix < 0x3fdc0000) {
		if (ix < 0x3e400000) {
			if (ix < 0x00100000)

			;
			return x;
		}
		id = -1;
	} else {
		x = fabs(x);
		if (ix < 0x3ff30000) {
			if (ix < 0x3fe60000) {
				id = 0;
				x = (2.0*x-1.0)/(2.0+x);
			} else {
				id = 1;
				x = (x-1.0)/(x+1.0);
			}
		} else {
			if (ix < 0x40038000) {
				id = 2;
				x = (x-1.5)/(1.0+1.5*x);
			} else {
				id = 3;
				x = -1.0/x;
			}
		}
	}

	z = x*x;
	w = z*z;

	s1 = z*(atan_aT[0]+w*(atan_aT[2]+w*(atan_aT[4]+w*(atan_aT[6]+w*(atan_aT[8]+w*atan_aT[10])))));
	s2 = w*(atan_aT[1]+w*(atan_aT[3]+w*(atan_aT[5]+w*(atan_aT[7]+w*atan_aT[9]))));
	if (id < 0)
		return x - x*(s1+s2);
	z = atan_atanhi[id] - (x*(s1+s2) - atan_atanlo[id] - x);
	return sign ? -z : z;
}

/* ---- atan2.c ---- */

/*
 * ====================================================
 * Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
 *
 * Developed at SunSoft, a Sun Microsystems, Inc. business.
 * Permission to use, copy, modify, and distribute this
 * software is freely granted, provided that this notice
 * is preserved.
 * ====================================================
 *
 */

static const double
atan2_pi     = 3.1415926535897931160E+00,
atan2_pi_lo  = 1.2246467991473531772E-16;

static APART double musl_atan2(double y, double x)
{
	double z;
	uint32_t m,lx,ly,ix,iy;

	if (isnan(x) || isnan(y))
		return x+y;
	musl_extract_words(ix, lx, x);
	musl_extract_words(iy, ly, y);
	if ((ix-0x3ff00000 | lx) == 0)
		return musl_atan(y);
	m = ((iy>>31)&1) | ((ix>>30)&2);
	ix = ix & 0x7fffffff;
	iy = iy & 0x7fffffff;

	if ((iy|ly) == 0) {
		switch(m) {
		case 0:
		case 1: return y;
		case 2: return  atan2_pi;
		case 3: return -atan2_pi;
		}
	}

	if ((ix|lx) == 0)
		return m&1 ? -atan2_pi/2 : atan2_pi/2;

	if (ix == 0x7ff00000) {
		if (iy == 0x7ff00000) {
			switch(m) {
			case 0: return  atan2_pi/4;
			case 1: return -atan2_pi/4;
			case 2: return  3*atan2_pi/4;
			case 3: return -3*atan2_pi/4;
			}
		} else {
			switch(m) {
			case 0: return  0.0;
			case 1: return -0.0;
			case 2: return  atan2_pi;
			case 3: return -atan2_pi;
			}
		}
	}

	if (ix+(64<<20) < iy || iy == 0x7ff00000)
		return m&1 ? -atan2_pi/2 : atan2_pi/2;

	if ((m&2) && iy+(64<<20) < ix)
		z = 0;
	else
		z = musl_atan(fabs(y/x));
	switch (m) {
	case 0: return z;
	case 1: return -z;
	case 2: return atan2_pi - (z-atan2_pi_lo);
	default:
		return (z-atan2_pi_lo) - atan2_pi;
	}
}
