/* The light of an accretion disk along a ray through a lens. For OSL only; disk.h has the physics.
 *
 * A ray crosses the equator's plane any number of times. At each crossing the disk adds its light, dimmed by what the ray has
 * gone through before, and lets a part of what comes from behind pass.
 */
#ifndef BENT_OSL_DISK_LIGHT_H
#define BENT_OSL_DISK_LIGHT_H
#include "disk.h"
#include "transport.h"

#define DISK_NONE 0
#define DISK_PAGE_THORNE 1
#define DISK_POWER_LAW 2
#define DISK_RAMP 3
#define DISK_IMAGE 4
#define DISK_MATERIAL 5
#define DISK_CROSSINGS 4 /* of a ray, that a material is told of */

struct Disk {
  int emission;
  float inner, outer, soft; /* radii in masses; over the last the outer edge fades */
  float temperature, exponent, hottest; /* in K; of the power law; the largest flux */
  string colors;            /* blackbodies over ln T, the ramp from the inner to the outer edge, or the image */
  float coldest, hot, size; /* the blackbodies' first and last temperature; entries of the row, or lines of the image */
  int is_srgb, is_associated; /* how the image holds its colors: on the sRGB curve; multiplied by alpha */
  float reference;          /* ln of the luminance that strength 1 stands for */
  float strength, opacity, doppler, gravitational;
  float contrast, scale, phase, period; /* of the pattern */
};

/* Entry of a row of colors, 0 to 1, and its fourth channel. */
color disk_entry(Disk disk, float at, output float fourth)
{
  float u = (clamp(at, 0, 1) * (disk.size - 1) + 0.5) / disk.size;
  fourth = texture(disk.colors, u, 0.5, 0, 0, 0, 0, "wrap", "clamp", "interp", "linear", "firstchannel", 3);
  return texture(disk.colors, u, 0.5, 0, 0, 0, 0, "wrap", "clamp", "interp", "linear");
}

float disk_decoded(float value) { return value < 0.04045 ? max(value, 0) / 12.92 : pow((value + 0.055) / 1.055, 2.4); }

/* The image: around the hole from left to right, `depth` from the inner edge upwards. As the core's operation image. */
color disk_image(Disk disk, float azimuth, float depth, output float alpha)
{
  float edge = 0.5 / disk.size, s = azimuth / M_2PI, t = 1 - clamp(depth, edge, 1 - edge);
  color rgb = texture(disk.colors, s, t, 0, 0, 0, 0, "swrap", "periodic", "twrap", "clamp", "interp", "linear");
  alpha = texture(disk.colors, s, t, 0, 0, 0, 0, "swrap", "periodic", "twrap", "clamp", "interp", "linear",
                  "firstchannel", 3);
  if (disk.is_associated && alpha != 0) rgb /= alpha;
  return disk.is_srgb ? color(disk_decoded(rgb[0]), disk_decoded(rgb[1]), disk_decoded(rgb[2])) : rgb;
}

/* As the core's operation blackbody_light. */
color disk_blackbody(Disk disk, float kelvin)
{
  if (kelvin < disk.coldest) return color(0);
  float clamped = min(kelvin, disk.hot), stored;
  color rgb = disk_entry(disk, log(clamped / disk.coldest) / log(disk.hot / disk.coldest), stored);
  return rgb * disk_luminance_from_stored(stored - disk.reference, clamped) * max(kelvin / disk.hot, 1);
}

/* Where and how a ray crosses the disk's plane: radius, azimuth from 0 to 2 pi, the factors of its frequency, and what the
 * pattern is there. */
struct Crossing {
  float r, azimuth, doppler, gravitational, noise;
};

/* 1 on the disk, 0 outside, in between along its soft edge. */
float disk_cover(Disk disk, float r)
{
  if (!(r > disk.inner && r < disk.outer)) return 0;
  return disk.soft > 0 ? 1 - smoothstep(disk.outer - disk.soft, disk.outer, r) : 1;
}

float disk_shift(Disk disk, Crossing at)
{
  return pow(at.doppler, disk.doppler) * pow(at.gravitational, disk.gravitational);
}

/* Radiance at a crossing, and the part that the disk covers. */
color disk_radiance(Disk disk, Crossing at, float a, output float cover)
{
  color light;
  float g = disk_shift(disk, at);
  cover = disk.opacity * disk_cover(disk, at.r);
  if (cover == 0) return color(0);
  if (disk.emission == DISK_RAMP || disk.emission == DISK_IMAGE) {
    float depth = (at.r - disk.inner) / (disk.outer - disk.inner), alpha;
    light = disk.emission == DISK_RAMP ? disk_entry(disk, depth, alpha) : disk_image(disk, at.azimuth, depth, alpha);
    light *= shifted_brightness(g);
    cover *= alpha;
  } else {
    float part = disk.emission == DISK_POWER_LAW ? pow(at.r / disk.inner, -disk.exponent)
                                                 : pow(disk_flux(at.r, a) / disk.hottest, 0.25);
    light = disk_blackbody(disk, disk.temperature * part * g);
  }
  if (disk.contrast > 0) {
    float factor = disk_pattern_factor(at.noise, disk.contrast);
    light *= factor;
    cover *= min(factor, 1);
  }
  return disk.strength * light;
}

/* Where a ray crosses the plane within its next step of Mino time h: Newton's method from the chord. */
Ray crossed(Space space, Ray ray, Ray next, float h)
{
  float step = h * ray.n[2] / (ray.n[2] - next.n[2]);
  Ray there = advanced(space, ray, step);
  for (int i = 0; i < 3 && abs(there.n[2]) > 1e-7; i++) {
    step -= there.n[2] / there.m[2];
    there = advanced(space, ray, step);
  }
  return there;
}

/* `energy`: conserved, over that at the ray's start. */
Crossing crossing_of(Space space, Disk disk, Ray there, float energy)
{
  point p;
  vector d;
  placed(space, there, p, d);
  float a = abs(space.a), sense = space.a < 0 ? -1 : 1, flat = hypot(p[0], p[1]);
  float k_r = -(d[0] * p[0] + d[1] * p[1]) / flat, k_phi = sense * (d[0] * p[1] - d[1] * p[0]) / flat;
  Crossing at;
  at.r = 1 / there.x, at.azimuth = atan2(p[1], p[0]);
  if (at.azimuth < 0) at.azimuth += M_2PI;
  at.doppler = disk_doppler(at.r, a, k_r, k_phi), at.gravitational = disk_gravitational(at.r, a, k_phi) / energy;
  at.noise = 0;
  if (disk.contrast > 0 || disk.emission == DISK_MATERIAL)
    at.noise = disk_pattern(at.r, a, sense * at.azimuth, disk.phase, disk.period, disk.scale);
  return at;
}

/* What a disk's own material is told of the first crossings of a ray, in order. */
struct Crossings {
  vector place[DISK_CROSSINGS]; /* part that is covered (0: no crossing), radius, azimuth */
  vector shift[DISK_CROSSINGS]; /* of frequency: by the sliders, Doppler, gravitational */
  vector more[DISK_CROSSINGS];  /* crossings of the plane before, pattern, 0 */
  int count;
};

void note_crossing(Disk disk, Crossing at, int order, output Crossings seen)
{
  float cover = disk_cover(disk, at.r);
  if (cover == 0 || seen.count == DISK_CROSSINGS) return;
  seen.place[seen.count] = vector(cover, at.r, at.azimuth);
  seen.shift[seen.count] = vector(disk_shift(disk, at), at.doppler, at.gravitational);
  seen.more[seen.count] = vector(order, at.noise, 0);
  seen.count += 1;
}

/* As follow() of transport.h, past the disk. Its light on the way and the part of what comes from behind that passes; or, if
 * it has a material of its own, what that is to know, and all passes. The frequency is that at the start, or at infinity for
 * rays that enter from outside. */
int follow_past_disk(Space space, Disk disk, point start, vector direction, int entering, output point p,
                     output vector d, output color glow, output float passed, output Crossings seen)
{
  Ray ray, next;
  glow = 0, passed = 1, seen.count = 0;
  for (int i = 0; i < DISK_CROSSINGS; i++) seen.place[i] = 0, seen.shift[i] = 1, seen.more[i] = 0;
  if (!launch(space, start, direction, ray)) return FATE_LOST;
  float energy = entering ? 1 : ray.E, h;
  int order = 0;
  for (int i = 0; i < STEPS_MAX; i++) {
    int fate = stepped(space, ray, next, h);
    if (ray.n[2] * next.n[2] < 0) {
      Crossing at = crossing_of(space, disk, crossed(space, ray, next, h), energy);
      if (disk.emission == DISK_MATERIAL) {
        note_crossing(disk, at, order, seen);
      } else {
        float cover;
        color light = disk_radiance(disk, at, abs(space.a), cover);
        glow += passed * cover * light;
        passed *= 1 - cover;
      }
      order += 1;
    }
    if (fate == FATE_NEAR) placed(space, next, p, d);
    if (fate == FATE_INSIDE && next.x * disk.inner > 1 && is_captured(space, next)) fate = FATE_LOST;
    if (fate != FATE_INSIDE || passed < 1e-4) return fate == FATE_INSIDE ? FATE_LOST : fate;
    ray = next;
  }
  return FATE_LOST;
}
#endif
