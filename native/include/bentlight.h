/* Bentlight's native core: light in curved spacetime. This header gathers the topics; read them in this order.
 *
 * Units G = c = 1; lengths in scene units. Matrices are row-major and act on column vectors. Every function that can
 * fail returns a bent_status and fills a caller-owned bent_error. Functions that take a const bent_scene may be called
 * from any number of threads at once. The core creates no threads.
 */
#ifndef BENTLIGHT_H
#define BENTLIGHT_H
#include "bentlight/error.h"     /* status, message, cancel and progress */
#include "bentlight/spacetime.h" /* the spacetimes, their charts and local frames */
#include "bentlight/trace.h"     /* rays to infinity or the horizon */
#include "bentlight/connect.h"   /* the rays that join two points */
#include "bentlight/table.h"     /* deflection tables */
#include "bentlight/sphere.h"    /* crossing a lens sphere by table */
#include "bentlight/embree.h"    /* the ray-triangle library, found at run time */
#include "bentlight/scene.h"     /* meshes, instances, spacetime objects */
#include "bentlight/shading.h"   /* images, materials, the world */
#include "bentlight/intersect.h" /* curved rays against the scene */
#include "bentlight/veil.h"      /* the same through accretion disks */
#include "bentlight/labels.h"    /* names and groups that passes tell things apart by */
#include "bentlight/motion.h"    /* where things are in the frames before and after */
#include "bentlight/render.h"    /* path tracing by tiles */
#include "bentlight/stars.h"     /* points of the sky, without noise */
#endif
