/* Asks the processor, once, which instruction set to use. */
#include "base/isa.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#ifndef BENT_SINGLE_ISA
#include <cpuid.h>

static const char *const NAMES[] = {"v2", "v3", "v4"};

/* What the operating system saves of the registers when threads take turns: vectors of 256 and of 512 bits. */
enum { SAVED_AVX = 0x06, SAVED_AVX512 = 0xe6 };

static unsigned saved_registers(void)
{
  unsigned low, high;
  __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  return low;
}

/* By the processor's own instruction: not every compiler's library fills in what __builtin_cpu_supports reads. */
static int detect(void)
{
  const unsigned v3 = bit_AVX2 | bit_BMI2;
  const unsigned v4 = bit_AVX512F | bit_AVX512BW | bit_AVX512CD | bit_AVX512DQ | bit_AVX512VL;
  unsigned a, b, c, d, extended;
  int best = BENT_ISA_INDEX_V2;
  if (__get_cpuid(1, &a, &b, &c, &d) && c & bit_FMA && c & bit_OSXSAVE && __get_cpuid_count(7, 0, &a, &extended, &c, &d)) {
    const unsigned saved = saved_registers();
    if ((saved & SAVED_AVX) == SAVED_AVX && (extended & v3) == v3) best = BENT_ISA_INDEX_V3;
    if (best == BENT_ISA_INDEX_V3 && (saved & SAVED_AVX512) == SAVED_AVX512 && (extended & v4) == v4)
      best = BENT_ISA_INDEX_V4;
  }
  const char *wanted = getenv("BENTLIGHT_ISA");
  for (int i = 0; wanted && i <= best; i++)
    if (!strcmp(wanted, NAMES[i])) return i;
  return best;
}

int bent_isa(void)
{
  static _Atomic int chosen = -1;
  int isa = atomic_load_explicit(&chosen, memory_order_relaxed);
  if (isa < 0) atomic_store_explicit(&chosen, isa = detect(), memory_order_relaxed);
  return isa;
}
const char *bent_isa_name(void) { return NAMES[bent_isa()]; }
#else
#define BENT_QUOTE_(name) #name
#define BENT_QUOTE(name) BENT_QUOTE_(name)

int bent_isa(void) { return 0; }
const char *bent_isa_name(void) { return BENT_QUOTE(BENT_SINGLE_ISA); }
#endif
