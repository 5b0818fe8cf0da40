/* Asks the processor, once, which instruction set to use. */
#include "base/isa.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#ifndef BENT_SINGLE_ISA
static const char *const NAMES[] = {"v2", "v3", "v4"};

static int detect(void)
{
  __builtin_cpu_init();
  int best = BENT_ISA_INDEX_V2;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
    best = BENT_ISA_INDEX_V3;
  if (best == BENT_ISA_INDEX_V3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    best = BENT_ISA_INDEX_V4;
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
