// Rays through a scene of Embree 3 or 4, which take a query's arguments in different structs and places. Whoever links
// gpvc_embree includes this as <embree_rays.h>, and through it Embree's own header. Active rays have -1 in `valid`, others 0.
#pragma once

#if GPVC_EMBREE == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

namespace gpvc::embree {

#if GPVC_EMBREE == 3

enum class Rays { any, coherent };

inline RTCIntersectContext context_of(Rays rays) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (rays == Rays::coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

inline void intersect(RTCScene scene, RTCRayHit& ray) {
  RTCIntersectContext context = context_of(Rays::any);
  rtcIntersect1(scene, &context, &ray);
}
inline void intersect(const int* valid, RTCScene scene, RTCRayHit4& rays) {
  RTCIntersectContext context = context_of(Rays::coherent);
  rtcIntersect4(valid, scene, &context, &rays);
}
inline void intersect(const int* valid, RTCScene scene, RTCRayHit16& rays) {
  RTCIntersectContext context = context_of(Rays::coherent);
  rtcIntersect16(valid, scene, &context, &rays);
}
/// Sets tfar of rays that hit something to minus infinity.
inline void occlude(const int* valid, RTCScene scene, RTCRay4& rays) {
  RTCIntersectContext context = context_of(Rays::any);
  rtcOccluded4(valid, scene, &context, &rays);
}
inline void occlude(const int* valid, RTCScene scene, RTCRay16& rays) {
  RTCIntersectContext context = context_of(Rays::coherent);
  rtcOccluded16(valid, scene, &context, &rays);
}

#else

inline RTCIntersectArguments coherent_hits() {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  return arguments;
}

inline void intersect(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &ray); }
inline void intersect(const int* valid, RTCScene scene, RTCRayHit4& rays) {
  RTCIntersectArguments arguments = coherent_hits();
  rtcIntersect4(valid, scene, &rays, &arguments);
}
inline void intersect(const int* valid, RTCScene scene, RTCRayHit16& rays) {
  RTCIntersectArguments arguments = coherent_hits();
  rtcIntersect16(valid, scene, &rays, &arguments);
}
/// Sets tfar of rays that hit something to minus infinity.
inline void occlude(const int* valid, RTCScene scene, RTCRay4& rays) { rtcOccluded4(valid, scene, &rays); }
inline void occlude(const int* valid, RTCScene scene, RTCRay16& rays) {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcOccluded16(valid, scene, &rays, &arguments);
}

#endif

}  // namespace gpvc::embree
