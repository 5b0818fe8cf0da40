/* Making, checking, folding and running programs. */
#include "scene/program.h"

#include <stdlib.h>
#include <string.h>

typedef enum row_kind { PURE, PER_POINT, SCATTERS, EMITS, SEE_THROUGH, PRINCIPLED, LAYER, RECORDS } row_kind;

typedef struct row {
  bent_opcode info;
  operation *run;
  row_kind kind;
} row;

/* Immediates that are plain numbers. */
static const char *const image_index[] = {NULL}, *const table_start[] = {NULL}, *const table_count[] = {NULL},
                         *const attribute_id[] = {NULL}, *const tile_count[] = {NULL},
                         *const ray_count[] = {NULL}, *const aov_index[] = {NULL};

#define STRING(name) #name,
#define NAMES(list) (const char *const[]){list(STRING) NULL}
#define NONE NULL
#define ROW(name, outputs, operands, kind, ...) {{#name, outputs, operands, {__VA_ARGS__}}, op_##name, kind},
static const row rows[] = {PROGRAM_OPS(ROW)};
enum { ROWS = sizeof rows / sizeof *rows };

const bent_opcode *bent_opcode_info(int index) { return index >= 0 && index < ROWS ? &rows[index].info : NULL; }

static int immediate_count(const row *r)
{
  int n = 0;
  while (r->info.choices[n]) n++;
  return n;
}
static size_t instruction_length(const row *r) { return 2 + r->info.operands + immediate_count(r); }

static int64_t min_count(int64_t a, int64_t b) { return a < b ? a : b; }

/* One instruction: checks operands, immediates and registers. `written` is the number of registers in use so far. */
static bent_status check_instruction(const bent_program *p, const int32_t *code, size_t at, int image_count, int *written,
                                     bent_error *error)
{
  const row *r = &rows[code[0]];
  const char *name = r->info.name;
  if (r->info.outputs && code[1] != *written)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "program: %s at %zu: output register %d, expected %d", name, at, code[1],
                     *written);
  if (*written + r->info.outputs > PROGRAM_REGISTERS)
    return bent_fail(error, BENT_ERROR_ARGUMENT, "program: too many nodes, they compute more than %d values",
                     PROGRAM_REGISTERS);
  for (int i = 0; i < r->info.operands; i++) {
    const int32_t operand = code[2 + i];
    if (operand >= *written || (operand < 0 && (size_t)(-1 - (int64_t)operand) >= p->constant_count))
      return bent_fail(error, BENT_ERROR_ARGUMENT, "program: %s at %zu: operand %d is %d, which does not exist", name, at,
                       i, operand);
  }
  const int32_t *immediates = code + 2 + r->info.operands;
  for (int i = 0; r->info.choices[i]; i++) {
    const char *const *names = r->info.choices[i];
    int64_t limit = 0;
    if (names == image_index) limit = image_count;
    else if (names == table_start) limit = (int64_t)p->table_length;
    else if (names == table_count) limit = (int64_t)p->table_length - immediates[i - 1] + 1;
    else if (names == tile_count) limit = min_count(image_count - immediates[0], (int64_t)p->table_length - immediates[i - 1]) + 1;
    else if (names == attribute_id || names == ray_count || names == aov_index) limit = INT32_MAX;
    else while (names[limit]) limit++;
    if (immediates[i] < (names == table_count || names == tile_count) || immediates[i] >= limit)
      return bent_fail(error, BENT_ERROR_ARGUMENT, "program: %s at %zu: immediate %d is %d, not within 0 to %lld", name, at,
                       i, immediates[i], (long long)limit - 1);
  }
  *written += r->info.outputs;
  return BENT_OK;
}

static bent_status check(const bent_program *p, int image_count, bent_error *error)
{
  int written = 0;
  for (size_t at = 0; at < p->code_length;) {
    const int32_t opcode = p->code[at];
    if (opcode < 0 || opcode >= ROWS)
      return bent_fail(error, BENT_ERROR_ARGUMENT, "program: no operation %d (at %zu)", opcode, at);
    const size_t length = instruction_length(&rows[opcode]);
    if (length > p->code_length - at)
      return bent_fail(error, BENT_ERROR_ARGUMENT, "program: %s at %zu is cut off", rows[opcode].info.name, at);
    const bent_status status = check_instruction(p, p->code + at, at, image_count, &written, error);
    if (status) return status;
    at += length;
  }
  for (size_t i = 0; i < p->constant_count; i++)
    if (!v3_is_finite(v3_from(p->constants[i])))
      return bent_fail(error, BENT_ERROR_ARGUMENT, "program: constant %zu is not finite", i);
  return BENT_OK;
}

static const vec3 *operand(const program *p, const vec3 *registers, int32_t index)
{
  return index >= 0 ? &registers[index] : &p->constants[-1 - (int64_t)index];
}

static void run_instruction(const program *p, const int32_t *code, vec3 *registers, const program_context *context)
{
  const row *r = &rows[code[0]];
  const vec3 *in[OPERANDS_MAX];
  for (int i = 0; i < r->info.operands; i++) in[i] = operand(p, registers, code[2 + i]);
  r->run(context, in, code + 2 + r->info.operands, registers + code[1]);
}

/* Runs the instructions that depend on constants only, appends their results to the constants, and drops them. Registers
 * keep their numbers; `constant_of` maps a folded register to its constant. */
static void fold(program *p)
{
  vec3 registers[PROGRAM_REGISTERS];
  int32_t constant_of[PROGRAM_REGISTERS] = {0};
  const program_context context = {.table = (const float(*)[4])p->table};
  size_t kept = 0;
  for (size_t at = 0, length; at < p->code_length; at += length) {
    int32_t *code = p->code + at;
    const row *r = &rows[code[0]];
    length = instruction_length(r);
    int constant = r->kind == PURE;
    for (int i = 0; i < r->info.operands; i++) {
      int32_t *o = &code[2 + i];
      if (*o >= 0 && constant_of[*o]) *o = constant_of[*o];
      constant &= *o < 0;
    }
    if (constant) {
      run_instruction(p, code, registers, &context);
      for (int i = 0; i < r->info.outputs; i++) {
        p->constants[p->constant_count++] = registers[code[1] + i];
        constant_of[code[1] + i] = -(int32_t)p->constant_count;
      }
    } else {
      memmove(p->code + kept, code, length * sizeof *code);
      kept += length;
    }
  }
  p->code_length = kept;
}

/* The most lobes that an operation adds, or has the next one add. */
static int lobes_of(const row *r)
{
  if (r->run == op_principled) return PRINCIPLED_LOBES;
  if (r->run == op_sheen_layer) return SHEEN_LAYER_LOBES;
  if (r->run == op_coat_layer) return COAT_LAYER_LOBES;
  if (r->run == op_subsurface || r->run == op_subsurface_layer) return SUBSURFACE_LOBES;
  return r->kind == SCATTERS || r->kind == SEE_THROUGH;
}

/* Whether an instruction tells the length of the ray. */
static int asks_length(const int32_t *code)
{
  const row *r = &rows[code[0]];
  if (r->run == op_coordinate) return code[2] == COORDINATE_RAY_LENGTH;
  return r->run == op_sphere_lamp || r->run == op_spot_cone || r->run == op_light_falloff;
}

/* What the host asks about a material as a whole. A lobe with a constant weight of 0 does not count. */
static void classify(program *p)
{
  int image_order = -1;
  for (size_t at = 0; at < p->code_length; at += instruction_length(&rows[p->code[at]])) {
    const int32_t *code = p->code + at;
    const row_kind kind = rows[code[0]].kind;
    const vec3 zero = v3(0, 0, 0), *in[OPERANDS_MAX] = {NULL};
    for (int i = 0; i < rows[code[0]].info.operands; i++) {
      if (code[2 + i] < 0) in[i] = operand(p, NULL, code[2 + i]);
      else if (code[2 + i] == image_order) p->asks_history = 1;
    }
    if (rows[code[0]].run == op_disk) image_order = code[1] + 4;
#define IS_ZERO(i) (in[i] && in[i]->x == zero.x && in[i]->y == zero.y && in[i]->z == zero.z)
    if (rows[code[0]].run == op_light_path && code[2] >= PATH_IS_DIFFUSE) p->asks_scattering = 1;
    p->lobe_count += lobes_of(&rows[code[0]]);
    if (rows[code[0]].run == op_light_path) p->asks_history = 1;
    if (asks_length(code)) p->asks_length = 1;
    if (rows[code[0]].run == op_normal_map || rows[code[0]].run == op_normal_map_along) p->asks_tangent = 1;
    if (rows[code[0]].run == op_disk) p->asks_frequency = 1;
    if (kind == SEE_THROUGH && !IS_ZERO(0) && !IS_ZERO(1)) p->may_be_transparent = 1;
    if (kind == EMITS && !IS_ZERO(0) && !IS_ZERO(1) && !IS_ZERO(2)) p->may_emit = 1;
    if (kind == PRINCIPLED && !IS_ZERO(0)) {
      if (!(in[9] && in[9]->x >= 1)) p->may_be_transparent = 1;
      if (!IS_ZERO(9) && !IS_ZERO(11) && !IS_ZERO(12)) p->may_emit = 1;
    }
#undef IS_ZERO
  }
  if (p->asks_length && p->lobe_count) p->asks_history = 1;
}

/* Whether nothing depends on the place but how it scatters; then what it emits is known beforehand. */
static void find_even_emission(program *p)
{
  p->emits_evenly = 1;
  for (size_t at = 0; at < p->code_length; at += instruction_length(&rows[p->code[at]])) {
    const row_kind kind = rows[p->code[at]].kind;
    p->emits_evenly &= kind == EMITS || kind == SCATTERS || kind == SEE_THROUGH || kind == RECORDS;
  }
  if (!p->emits_evenly) return;
  closure_set set = {0};
  program_context context = {.set = &set, .emission_only = 1};
  program_run(p, &context);
  p->emission = set.emission;
}

bent_status program_make(program *out, const bent_program *source, int image_count, bent_error *error)
{
  const bent_status status = check(source, image_count, error);
  if (status) return status;
  program p = {.code_length = source->code_length, .constant_count = source->constant_count,
               .table_length = source->table_length};
  p.code = malloc((p.code_length + 1) * sizeof *p.code);
  p.constants = malloc((p.constant_count + PROGRAM_REGISTERS) * sizeof *p.constants);
  p.table = malloc((p.table_length + 1) * sizeof *p.table);
  if (!p.code || !p.constants || !p.table) {
    program_free(&p);
    return bent_fail(error, BENT_ERROR_MEMORY, "program: out of memory");
  }
  for (size_t i = 0; i < p.code_length; i++) p.code[i] = source->code[i];
  for (size_t i = 0; i < p.constant_count; i++) p.constants[i] = v3_from(source->constants[i]);
  if (p.table_length) memcpy(p.table, source->table, p.table_length * sizeof *p.table);
  fold(&p);
  classify(&p);
  find_even_emission(&p);
  program_free(out);
  *out = p;
  return BENT_OK;
}

void program_free(program *program)
{
  free(program->code);
  free(program->constants);
  free(program->table);
  memset(program, 0, sizeof *program);
}

int program_next_sky_image(const program *program, size_t *at)
{
  while (*at < program->code_length) {
    const int32_t *code = program->code + *at, *immediates = code + 2 + rows[code[0]].info.operands;
    *at += instruction_length(&rows[code[0]]);
    if (rows[code[0]].run == op_environment && immediates[2] == 0) return immediates[0];
  }
  return -1;
}

void program_run(const program *program, program_context *context)
{
  vec3 registers[PROGRAM_REGISTERS];
  program_layers layers;
  layers.has_sheen = layers.has_coat = layers.has_subsurface = layers.has_film = 0;
  context->layers = &layers;
  context->table = (const float(*)[4])program->table;
  for (size_t at = 0; at < program->code_length;) {
    const int32_t *code = program->code + at;
    run_instruction(program, code, registers, context);
    at += instruction_length(&rows[code[0]]);
  }
}
