// What the yardsticks ask of Embree 3 and of Embree 4, whose calls differ. EMBREE is the version: that of the library
// that the program is linked with.
#pragma once

#ifndef EMBREE
#define EMBREE 3
#endif

#if EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

enum class Rays { COHERENT, INCOHERENT };

#if EMBREE >= 4

template <class Arguments>
inline Arguments embree_arguments(void (*init)(Arguments*), Rays rays) {
  Arguments arguments;
  init(&arguments);
  arguments.flags = rays == Rays::COHERENT ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
  arguments.feature_mask = RTCFeatureFlags(RTC_FEATURE_FLAG_TRIANGLE | RTC_FEATURE_FLAG_SPHERE_POINT);
  return arguments;
}

inline void find_nearest(const int* valid, RTCScene scene, RTCRayHit16& packet, Rays rays) {
  auto arguments = embree_arguments(rtcInitIntersectArguments, rays);
  rtcIntersect16(valid, scene, &packet, &arguments);
}

inline void find_occluded(const int* valid, RTCScene scene, RTCRay16& packet, Rays rays) {
  auto arguments = embree_arguments(rtcInitOccludedArguments, rays);
  rtcOccluded16(valid, scene, &packet, &arguments);
}

inline void find_nearest(RTCScene scene, RTCRayHit& ray, Rays rays) {
  auto arguments = embree_arguments(rtcInitIntersectArguments, rays);
  rtcIntersect1(scene, &ray, &arguments);
}

inline void find_occluded(RTCScene scene, RTCRay& ray, Rays rays) {
  auto arguments = embree_arguments(rtcInitOccludedArguments, rays);
  rtcOccluded1(scene, &ray, &arguments);
}

#else

inline RTCIntersectContext embree_context(Rays rays) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags =
      rays == Rays::COHERENT ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return context;
}

inline void find_nearest(const int* valid, RTCScene scene, RTCRayHit16& packet, Rays rays) {
  auto context = embree_context(rays);
  rtcIntersect16(valid, scene, &context, &packet);
}

inline void find_occluded(const int* valid, RTCScene scene, RTCRay16& packet, Rays rays) {
  auto context = embree_context(rays);
  rtcOccluded16(valid, scene, &context, &packet);
}

inline void find_nearest(RTCScene scene, RTCRayHit& ray, Rays rays) {
  auto context = embree_context(rays);
  rtcIntersect1(scene, &context, &ray);
}

inline void find_occluded(RTCScene scene, RTCRay& ray, Rays rays) {
  auto context = embree_context(rays);
  rtcOccluded1(scene, &context, &ray);
}

#endif
