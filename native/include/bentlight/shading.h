/* Images, materials and the world of a scene.
 *
 * A material or the world is a program: a Blender node tree that the host compiled for the small register machine of
 * scene/program.h. Images are given as scene-linear pixels; how they are looked up is said by the program.
 */
#ifndef BENTLIGHT_SHADING_H
#define BENTLIGHT_SHADING_H
#include "bentlight/scene.h"

/* Rows from the bottom up, RGB with associated alpha, copied. Either floats (finite, scene-linear) or bytes, which are
 * divided by 255 and interpolated as they are, and only then decoded if `srgb` is set. The other pointer is NULL. */
typedef struct bent_image {
  size_t width, height; /* 1 to 65536 each */
  const float (*pixels)[4];
  const uint8_t (*bytes)[4];
  int srgb; /* values are encoded by the sRGB curve */
} bent_image;

/* A program: instructions one after the other, each `opcode, first output register, operands ..., immediates ...` with
 * the counts of bent_opcode_info. Registers hold three doubles (a float socket: the same value three times). An operand
 * >= 0 is a register that an earlier instruction has written, an operand < 0 is constant number -1 - operand. */
typedef struct bent_program {
  size_t code_length;
  const int32_t *code;
  size_t constant_count;
  const double (*constants)[3];
  size_t table_length; /* entries of all color ramps, one after the other */
  const float (*table)[4];
} bent_program;

enum { BENT_IMMEDIATES_MAX = 6 };
typedef struct bent_opcode {
  const char *name;
  int outputs, operands;
  /* For each immediate the names of its values 0, 1, ..., as Blender spells them, ended by NULL; an empty list for a
   * plain number. NULL past the last immediate. */
  const char *const *choices[BENT_IMMEDIATES_MAX + 1];
} bent_opcode;

/* The instruction set: opcode `index` from 0; NULL past the last. The only place that knows the numbers. */
const bent_opcode *bent_opcode_info(int index);

bent_status bent_scene_add_image(bent_scene *scene, const bent_image *image, int *index, bent_error *error);
bent_status bent_scene_update_image(bent_scene *scene, int index, const bent_image *image, bent_error *error);
/* The program is checked here: a malformed one is BENT_ERROR_ARGUMENT and names the instruction. Images it uses must
 * have been added before. */
bent_status bent_scene_add_material(bent_scene *scene, const bent_program *program, int *index, bent_error *error);
bent_status bent_scene_update_material(bent_scene *scene, int index, const bent_program *program, bent_error *error);
/* The sky: runs with the asymptotic direction as position, generated coordinate and reversed normal. NULL: black. */
bent_status bent_scene_set_world(bent_scene *scene, const bent_program *program, bent_error *error);
/* How much gravity shifts light on its way: each color is seen (nu_observed / nu_emitted)^(4 amount) as bright and keeps its
 * hue. Surfaces, lamps and the camera are at rest with local observers (ZAMOs), the sky is at infinity. 0, the default: as in
 * films; 1: as in nature. Accretion disks have sliders of their own. */
bent_status bent_scene_set_gravitational(bent_scene *scene, double amount, bent_error *error);
/* How bright light is to the ends of n rays that it meets at `from` in direction `launch`, over how bright it starts, by that
 * amount: from `to`, which rays reach in direction `arrival`, or, where `sky` is not 0, from infinity. World places, local
 * unit directions. */
void bent_scene_shift_light(const bent_scene *scene, size_t n, const double (*from)[3], const double (*launch)[3],
                            const double (*to)[3], const double (*arrival)[3], const uint8_t *sky, double *brightness);
#endif
