/* Memory that begins at a cache line. Windows' C library has no aligned_alloc. */
#ifndef BENT_BASE_ALIGNED_H
#define BENT_BASE_ALIGNED_H
#include <stdlib.h>

enum { ALIGNED_LINE = 64 }; /* bytes */

#if defined(_WIN32)
#include <malloc.h>
static inline void *aligned_new(size_t size) { return _aligned_malloc(size, ALIGNED_LINE); }
static inline void aligned_release(void *memory) { _aligned_free(memory); }
#else
static inline void *aligned_new(size_t size)
{
  return aligned_alloc(ALIGNED_LINE, (size + ALIGNED_LINE - 1) / ALIGNED_LINE * ALIGNED_LINE);
}
static inline void aligned_release(void *memory) { free(memory); }
#endif
#endif
