/* The C interface from C alone: life and death of every handle, refused arguments, and no leak.
 *
 * Built with AddressSanitizer, UndefinedBehaviorSanitizer and LeakSanitizer (`make test`); truth is the Python tests'
 * matter. Ends with exit code 0 and one closing line, or stops at the first failed check.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "bentlight.h"

static int checks;

static void check(int condition, const char *text, int line)
{
  checks++;
  if (condition) return;
  fprintf(stderr, "smoke.c:%d: %s\n", line, text);
  exit(1);
}
#define CHECK(condition) check(!!(condition), #condition, __LINE__)

/* A refusal has its status and says why. */
static int refused(bent_status got, bent_status wanted, bent_error *error)
{
  int right = got == wanted && error->status == wanted && error->message[0];
  memset(error, 0, sizeof *error);
  return right;
}

static void test_errors(void)
{
  bent_error error = {0};
  CHECK(bent_fail(NULL, BENT_ERROR_DATA, "nobody listens") == BENT_ERROR_DATA);
  /* Longer than the message holds: cut, terminated. */
  CHECK(refused(bent_fail(&error, BENT_ERROR_DATA, "%2000d", 7), BENT_ERROR_DATA, &error));
}

static void test_spacetimes(void)
{
  bent_error error = {0};
  bent_spacetime spacetime = bent_minkowski();
  CHECK(spacetime.kind == BENT_MINKOWSKI);

  CHECK(bent_schwarzschild(1, BENT_CHART_ISOTROPIC, &spacetime, &error) == BENT_OK);
  CHECK(refused(bent_schwarzschild(-1, BENT_CHART_AREAL, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));
  CHECK(refused(bent_schwarzschild(NAN, BENT_CHART_AREAL, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));
  CHECK(refused(bent_schwarzschild(1, BENT_CHART_OBLATE, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));

  CHECK(bent_kerr(1, 0.9, &spacetime, &error) == BENT_OK);
  CHECK(refused(bent_kerr(1, 1, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));
  CHECK(refused(bent_kerr(INFINITY, 0, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));

  CHECK(bent_ellis(1, &spacetime, &error) == BENT_OK);
  CHECK(refused(bent_ellis(0, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));
}

int main(void)
{
  test_errors();
  test_spacetimes();
  printf("smoke: %d checks passed\n", checks);
  return 0;
}
