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
  const double far[3] = {10, 0, 0}, nowhere[3] = {NAN, 0, 0}, center[3] = {0, 0, 0};
  CHECK(spacetime.kind == BENT_MINKOWSKI);

  CHECK(bent_schwarzschild(1, BENT_CHART_ISOTROPIC, &spacetime, &error) == BENT_OK);
  CHECK(bent_spacetime_contains(&spacetime, far));
  CHECK(!bent_spacetime_contains(&spacetime, nowhere));
  CHECK(!bent_spacetime_contains(&spacetime, center));
  CHECK(refused(bent_schwarzschild(-1, BENT_CHART_AREAL, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));
  CHECK(refused(bent_schwarzschild(NAN, BENT_CHART_AREAL, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));
  CHECK(refused(bent_schwarzschild(1, BENT_CHART_OBLATE, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));

  CHECK(bent_kerr(1, 0.9, &spacetime, &error) == BENT_OK);
  CHECK(refused(bent_kerr(1, 1, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));
  CHECK(refused(bent_kerr(INFINITY, 0, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));

  CHECK(bent_ellis(1, &spacetime, &error) == BENT_OK);
  CHECK(refused(bent_ellis(0, &spacetime, &error), BENT_ERROR_ARGUMENT, &error));
}

static void test_rays(void)
{
  enum { COUNT = 37 }; /* not a whole number of lanes */
  bent_error error = {0};
  bent_spacetime hole;
  CHECK(bent_kerr(1, 0.9, &hole, &error) == BENT_OK);
  double origins[COUNT][3], directions[COUNT][3];
  for (int i = 0; i < COUNT; i++) {
    memcpy(origins[i], (double[3]){30, 0, 0.5}, sizeof origins[i]);
    memcpy(directions[i], (double[3]){-1, 0.02 * (i - COUNT / 2), 0}, sizeof directions[i]);
  }
  uint8_t fate[COUNT];
  double asymptotic[COUNT][3];
  const bent_trace_result fates = {.fate = fate}, all = {.fate = fate, .direction = asymptotic};
  CHECK(bent_trace_rays(&hole, COUNT, origins, directions, 1e-8, BENT_ROUTE_AUTO, &fates, NULL, &error) == BENT_OK);
  CHECK(fate[COUNT / 2] == BENT_CAPTURED);
  CHECK(fate[0] == BENT_ESCAPED);
  CHECK(bent_trace_rays(&hole, COUNT, origins, directions, 1e-8, BENT_ROUTE_TAYLOR, &all, NULL, &error) == BENT_OK);
  CHECK(isnan(asymptotic[COUNT / 2][0]));
  CHECK(bent_trace_rays(&hole, 0, NULL, NULL, 1e-8, BENT_ROUTE_AUTO, &all, NULL, &error) == BENT_OK);

  bent_progress stopped = {0};
  atomic_store(&stopped.cancel, 1);
  CHECK(bent_trace_rays(&hole, COUNT, origins, directions, 1e-8, BENT_ROUTE_AUTO, &all, &stopped, &error) ==
        BENT_CANCELLED);
  CHECK(refused(bent_trace_rays(&hole, COUNT, origins, directions, 0, BENT_ROUTE_AUTO, &all, NULL, &error),
                BENT_ERROR_ARGUMENT, &error));
  directions[3][1] = NAN;
  CHECK(refused(bent_trace_rays(&hole, COUNT, origins, directions, 1e-8, BENT_ROUTE_AUTO, &all, NULL, &error),
                BENT_ERROR_ARGUMENT, &error));
}

int main(void)
{
  test_errors();
  test_spacetimes();
  test_rays();
  printf("smoke: %d checks passed\n", checks);
  return 0;
}
