/* What CMSIS-DSP takes from CMSIS-Core, by the compiler's own intrinsics; only what the functions used here need. */
#pragma once
#include <arm_acle.h>
#include <stdint.h>
#define __ASM __asm
#define __INLINE inline
#define __STATIC_INLINE static inline
#define __STATIC_FORCEINLINE static inline __attribute__((always_inline))
#define __WEAK __attribute__((weak))
#define __ALIGNED(x) __attribute__((aligned(x)))
#define __PACKED __attribute__((packed))
#define __CLZ(x) ((uint8_t)__builtin_clz(x))
#define __SSAT(value, bits) __ssat(value, bits)
#define __USAT(value, bits) __usat(value, bits)
#define __ROR(value, bits) __ror(value, bits)
#define __QADD(a, b) __qadd(a, b)
#define __QSUB(a, b) __qsub(a, b)
#define __QADD8(a, b) __qadd8(a, b)
#define __QSUB8(a, b) __qsub8(a, b)
#define __QADD16(a, b) __qadd16(a, b)
#define __QSUB16(a, b) __qsub16(a, b)
#define __SHADD16(a, b) __shadd16(a, b)
#define __SHSUB16(a, b) __shsub16(a, b)
#define __QASX(a, b) __qasx(a, b)
#define __QSAX(a, b) __qsax(a, b)
#define __SHASX(a, b) __shasx(a, b)
#define __SHSAX(a, b) __shsax(a, b)
#define __SMUAD(a, b) __smuad(a, b)
#define __SMUADX(a, b) __smuadx(a, b)
#define __SMUSD(a, b) __smusd(a, b)
#define __SMUSDX(a, b) __smusdx(a, b)
#define __SMLAD(a, b, c) __smlad(a, b, c)
#define __SMLADX(a, b, c) __smladx(a, b, c)
#define __SMLSDX(a, b, c) __smlsdx(a, b, c)
#define __SMLALD(a, b, c) __smlald(a, b, c)
#define __SMLALDX(a, b, c) __smlaldx(a, b, c)
#define __SXTB16(a) __sxtb16(a)
#define __PKHBT(a, b, s) ((((uint32_t)(a)) & 0xFFFFu) | ((((uint32_t)(b)) << (s)) & 0xFFFF0000u))
#define __PKHTB(a, b, s) ((((uint32_t)(a)) & 0xFFFF0000u) | ((((uint32_t)(b)) >> (s)) & 0xFFFFu))
static inline int32_t __SMMLA(int32_t a, int32_t b, int32_t c) { return c + (int32_t)(((int64_t)a * b) >> 32); }
