/* The film gathers the samples of a strip of pixels, few enough for the sums to stay in the cache. */
#ifndef BENT_RENDER_FILM_H
#define BENT_RENDER_FILM_H
#include "render/channels.h"

enum { FILM_PIXELS = 4096 };
/* Samples of a pixel whose mean is one of the values that its noise is told from: successive samples are spread evenly, so
 * that such means scatter less than independent samples would, as does the picture. */
enum { FILM_GROUP = 8 };

/* Where a channel's sums are among those of a pixel: for each component one number, of means two, of mattes three for each
 * pair (see film.c). */
typedef struct film_entry {
  channel channel;
  bent_reduction reduction;
  uint32_t offset, components;
} film_entry;

/* What there is room for in each pixel: first how many samples it has and the first one's number, then the entries. */
typedef struct film_layout {
  int count;
  film_entry entries[CHANNEL_COUNT];
  uint32_t width; /* numbers of a pixel */
  int tells_noise;
} film_layout;

typedef struct film {
  film_layout layout;
  const channel_layout *records; /* of the samples */
  uint32_t taken[FILM_PIXELS]; /* whole samples */
  double *sums; /* layout.width for each pixel: `own`, or the caller's */
  double *own;
} film;

/* What a render with these settings gathers for wanted channels (bytes that are 0 or not). */
film_layout film_layout_of(const uint8_t wanted[CHANNEL_COUNT], const bent_render_settings *settings);
/* NULL: out of memory. */
film *film_new(const film_layout *layout, const channel_layout *records);
void film_free(film *film);
/* An empty film for a strip of pixels; the sums are kept in `state` if that is not NULL. */
void film_begin(film *film, double *state, uint32_t pixels, uint32_t first_sample);
/* A film that goes on with the sums in `state`. */
void film_resume(film *film, double *state, uint32_t pixels);
/* The first of the samples that the sums in `state` are of. */
uint32_t film_first_sample(const double *state);
/* Adds part number `part` of the `parts` that one sample of a pixel is taken in: together they count as any other sample,
 * though a pixel's next one may have another number of parts. The caller adds a pixel's samples in ascending order. */
void film_add(film *film, uint32_t pixel, const sample_record *record, uint32_t part, uint32_t parts);
/* The noise of a pixel's color, as Cycles measures it: standard errors over the square root of the color, so that dark
 * and bright parts look equally noisy. INFINITY before two groups of samples. */
double film_noise(const film *film, uint32_t pixel);
/* The opposite of film_write, to float rounding: takes up what earlier samples left in the channels' arrays, where
 * sample_count, which counts parts, must be among them. parts: of each sample of each pixel. */
void film_read(film *film, float *const channels[CHANNEL_COUNT], size_t first, uint32_t pixels, const uint8_t *parts);
/* Writes the first `pixels` pixels into the channels' arrays (NULL: not wanted), from their pixel number `first` on, and
 * their numbers of samples among the sums. */
void film_write(film *film, float *const channels[CHANNEL_COUNT], size_t first, uint32_t pixels);
#endif
