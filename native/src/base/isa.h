/* Run-time choice among the copies of a SIMD kernel.
 *
 * A file NAME.kernel.c is compiled once per instruction set. In it a function is named with BENT_KERNEL(name). A plain
 * header declares it once for all sets and the rest of the core calls it through BENT_CALL:
 *
 *     BENT_DECLARE_KERNEL(void, bent_trace_taylor, (const bent_spacetime *, size_t, ...))   // name.h
 *     void BENT_KERNEL(bent_trace_taylor)(const bent_spacetime *s, size_t n, ...) { ... }    // name.kernel.c
 *     BENT_CALL(bent_trace_taylor)(s, n, ...);                                               // anywhere
 */
#ifndef BENT_BASE_ISA_H
#define BENT_BASE_ISA_H

#define BENT_PASTE_(a, b) a##_##b
#define BENT_PASTE(a, b) BENT_PASTE_(a, b)
#define BENT_KERNEL(name) BENT_PASTE(name, BENT_ISA)

/* Where there is no choice: its name. */
#if !defined(__x86_64__)
#define BENT_SINGLE_ISA neon
#endif

#ifndef BENT_SINGLE_ISA
enum { BENT_ISA_INDEX_V2, BENT_ISA_INDEX_V3, BENT_ISA_INDEX_V4 };
#define BENT_DECLARE_KERNEL(result, name, arguments) \
  result name##_v2 arguments;                        \
  result name##_v3 arguments;                        \
  result name##_v4 arguments;
#define BENT_CALL(name) \
  (*(bent_isa() == BENT_ISA_INDEX_V4 ? name##_v4 : bent_isa() == BENT_ISA_INDEX_V3 ? name##_v3 : name##_v2))
#else
#define BENT_DECLARE_KERNEL(result, name, arguments) result BENT_PASTE(name, BENT_SINGLE_ISA) arguments;
#define BENT_CALL(name) BENT_PASTE(name, BENT_SINGLE_ISA)
#endif

/* The best instruction set of this processor, or the one named by the environment variable BENTLIGHT_ISA (v2, v3, v4),
 * which must be one that the processor has. Decided once. */
int bent_isa(void);
const char *bent_isa_name(void);
#endif
