/* The film gathers the samples of a strip of pixels, few enough for the sums to stay in the cache. */
#ifndef BENT_RENDER_FILM_H
#define BENT_RENDER_FILM_H
#include "render/channels.h"

enum { FILM_PIXELS = 4096 };
/* Samples of a pixel whose mean is one of the values that its noise is told from: successive samples are spread evenly, so
 * that such means scatter less than independent samples would, as does the picture. */
enum { FILM_GROUP = 8 };

typedef struct film {
  int count;                       /* channels that are gathered: those that are wanted, and `combined` */
  uint8_t gathered[CHANNEL_COUNT]; /* which */
  uint32_t taken[FILM_PIXELS];
  double sums[FILM_PIXELS][CHANNEL_COUNT][CHANNEL_COMPONENTS_MAX];
} film;

/* An empty film for those of the channels' arrays that are not NULL. */
void film_clear(film *film, float *const channels[CHANNEL_COUNT]);
/* Adds one sample of a pixel. The caller adds a pixel's samples in ascending order, so that sums never differ in a bit. */
void film_add(film *film, uint32_t pixel, const sample_record *record);
/* The noise of a pixel's color, as Cycles measures it: standard errors over the square root of the color, so that dark
 * and bright parts look equally noisy. INFINITY before two groups of samples. */
double film_noise(const film *film, uint32_t pixel);
/* The opposite of film_write: takes up what earlier samples left in the arrays, where sample_count must be among them. */
void film_read(film *film, float *const channels[CHANNEL_COUNT], size_t first, uint32_t pixels);
/* Writes the first `pixels` pixels into the channels' arrays (NULL: not wanted), from their pixel number `first` on. */
void film_write(const film *film, float *const channels[CHANNEL_COUNT], size_t first, uint32_t pixels);
#endif
