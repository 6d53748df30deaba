// How much memory a run takes, predicted before it starts, and how it is shared between what a run must hold and what it
// keeps to be faster.
#pragma once

#include <cstddef>
#include <filesystem>
#include <new>
#include <string>

#include "../../atlas/atlas.h"
#include "../../io/error.h"
#include "../../visibility/result.h"
#include "../checks/input.h"

namespace gpvc::pipeline {

using checks::Input;
struct Settings;

/// Bytes that this process may still take: what the machine has available, or less where a control group of Linux (v1 or
/// v2) limits it. `root`: where /proc and /sys are looked for.
std::size_t available_memory(const std::filesystem::path& root = "/");

/// The limit of a run that names none: 70 % of available_memory().
std::size_t default_memory_limit();

/// How much there is to do. Estimated from a sample of the faces, without occlusion.
struct Workload {
  double faces = 0, vertices = 0, views = 0;
  double pixels = 0, most_pixels = 0;  ///< of all views, of the largest one
  double pairs = 0;                    ///< of a face and a view that has it in its frame, from the front
  double pair_pixels = 0;              ///< that these show
  double texels = 0;                   ///< of all pages
  double page_texels = 0;              ///< of the largest page that there may be
  double sample_bytes = 0;             ///< of a pixel, where photos have bands (BandSet::pixel_bytes()), and of a texel
  double owner_bytes = 0;              ///< of a texel of a given layout, see atlas::kOwnerBytesPerTexel

  double page_texel_bytes() const;  ///< of a page that is painted
  double photo_pixel_bytes() const;
};

/// O(sampled faces x views), at most some million projections; TBB.
Workload workload(const Input& input, const Settings& settings);

/// Bytes that the stages need at least, without photos that are kept and without pages.
struct MemoryNeed {
  double see = 0, judge = 0, choose = 0, bake = 0, write = 0;
};
/// \param threads that views and labels are shared out to; baking and writing need the same for any number
MemoryNeed memory_need(const Workload& work, int threads = 1);

/// Wall seconds on so many cores.
double predicted_seconds(const Workload& work, int threads);

/// There is less memory than a run needs. what() is one sentence that says how much it needs; measures() are needed_bytes
/// and, where it is known, allowed_bytes.
class MemoryError : public Error {
 public:
  using Error::Error;
};

/// How a run uses its memory. Results do not depend on it.
struct MemoryPlan {
  double limit = 0;  ///< bytes that the run stays below
  double most = 0;   ///< that the limit may grow to: itself where one was set, else default_memory_limit()
  MemoryNeed need;
  Workload work;

  /// Bytes of photos to keep for the next pass.
  std::size_t photos_while_seeing() const;
  /// \param held bytes of what is known of the views and of judging them
  std::size_t photos_while_judging(double held) const;
  std::size_t photos_while_choosing() const;
  /// Shares while baking: of pages and charts that are baked together, see atlas::BakeOptions, and of photos.
  struct Shares {
    std::size_t pages = 0, batch = 0, photos = 0;
  };
  /// \param all_pages bytes of all pages
  /// \param page bytes of the largest one
  Shares while_baking(double all_pages, double page) const;
  /// Bytes that the run is expected to take at its peak, at most `limit`.
  double peak() const;
};

/// A limit that is given is used to keep photos decoded and to bake many pages together. Without one, a run takes little
/// more than its largest stage needs, and never more than default_memory_limit(). Throws MemoryError when the limit is too
/// low.
MemoryPlan plan_memory(const Input& input, const Settings& settings);
/// The same of a run that only bakes an atlas, without a preview, and holds what views see of partial faces. Never
/// refuses a limit of `promised` bytes or more, even if the run may exceed it: the plan that named it was made before the number
/// of partial faces was known.
MemoryPlan plan_baking(const Input& input, const Settings& settings, const visibility::CoverageTable& coverage,
                       double promised);
/// The plan of a run that knows by now what views see of partial faces, and holds it while the atlas is baked. The limit
/// grows by as much, where it may, so that pages and photos have the room that they had.
MemoryPlan with_coverage(MemoryPlan plan, const visibility::CoverageTable& coverage);

/// \param needed bytes that the run was expected to take: MemoryPlan::peak()
[[noreturn]] void throw_out_of_memory(double needed);
/// The result of work(). Where it finds no memory, the error says how much its plan asks for.
template <typename Work>
auto within(const MemoryPlan& plan, const Work& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    throw_out_of_memory(plan.peak());
  }
}

}  // namespace gpvc::pipeline
