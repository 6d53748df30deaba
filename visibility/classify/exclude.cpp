#include "visibility/exclude.h"

#include <algorithm>
#include <utility>

namespace gpvc::visibility {
namespace {

constexpr std::uint32_t kNoNumber = 0xFFFFFFFFu;

/// How many pixels a face had, and how many of those show background or a mixture with it.
struct Lost {
  std::uint32_t had = 0, background = 0, mixed = 0;

  void count(const ExcludedPixels& excluded, int x, int y) {
    ++had;
    background += excluded.background.contains(x, y) ? 1 : 0;
    mixed += excluded.mixed.contains(x, y) ? 1 : 0;
  }
  /// Of a face that has lost all of them.
  FaceClass face_class() const {
    if (2 * background >= had) return FaceClass::background;
    return 2 * (background + mixed) >= had ? FaceClass::mixed : FaceClass::hidden;
  }
};

/// The pixels of a face that remain.
struct Rest {
  Lost lost{};
  std::uint32_t has = 0;
  std::int32_t x0 = 0, y0 = 0, x1 = -1, y1 = -1;  ///< first and last pixels of their box
  std::size_t entry = 0;                          ///< of the face in the new coverage

  void add(std::int32_t x, std::int32_t y) {
    x0 = has == 0 ? x : std::min(x0, x);
    x1 = has == 0 ? x : std::max(x1, x);
    y0 = has == 0 ? y : y0;  // rows come one after another
    y1 = y;
    ++has;
  }
};

/// Clears or sets the bit of a pixel in its entry's box.
void set(CoverageTable& table, const FaceCoverage& entry, int x, int y, bool seen) {
  const std::int64_t bit = std::int64_t{y - entry.y0} * entry.width + (x - entry.x0);
  std::uint64_t& word = table.words[entry.first_word + static_cast<std::size_t>(bit / 64)];
  const std::uint64_t one = std::uint64_t{1} << (bit % 64);
  word = seen ? word | one : word & ~one;
}

std::size_t word_count(const FaceCoverage& entry) {
  return (static_cast<std::size_t>(entry.width) * static_cast<std::size_t>(entry.height) + 63) / 64;
}

class Exclusion {
 public:
  Exclusion(const Mesh& mesh, const View& view, ViewId id, const ExcludedPixels& excluded, ViewVisibility& seen)
      : mesh_(mesh), view_(view), id_(id), excluded_(excluded), seen_(seen), number_(seen.classes.size(), kNoNumber) {}

  std::size_t run() {
    const std::size_t count = find_full_faces();
    for (std::size_t f = 0; f < number_.size(); ++f)
      if (!has_pixel_[f] && seen_.classes[f] == FaceClass::full) look_at_centroid(f);
    if (count > 0) {
      measure_full_faces();
      make_coverage();
      clear_pixels();
    }
    return count;
  }

 private:
  /// Calls visit(x, y, face) for each pixel that shows a face, row by row.
  template <class Visit>
  void for_each_pixel(const Visit& visit) {
    FaceId* face = seen_.ivm.faces.data();
    for (int y = 0; y < seen_.ivm.height; ++y)
      for (int x = 0; x < seen_.ivm.width; ++x, ++face)
        if (*face != kNoFace) visit(x, y, *face);
  }

  /// Numbers the faces seen in full that lose pixels. Returns how many pixels are lost.
  std::size_t find_full_faces() {
    std::size_t count = 0;
    has_pixel_.assign(number_.size(), false);
    for_each_pixel([&](int x, int y, FaceId face) {
      has_pixel_[index(face)] = true;
      if (!excluded_.all.contains(x, y)) return;
      ++count;
      std::uint32_t& number = number_[index(face)];
      if (number != kNoNumber || seen_.classes[index(face)] != FaceClass::full) return;
      number = static_cast<std::uint32_t>(rest_.size());
      rest_.emplace_back();
    });
    return count;
  }

  void look_at_centroid(std::size_t face) {
    const Triangle& t = mesh_.faces[face];
    const WorldPoint &a = mesh_.positions[t[0]], &b = mesh_.positions[t[1]], &c = mesh_.positions[t[2]];
    const auto at = pixel_from_world(view_, {(a.x + b.x + c.x) / 3, (a.y + b.y + c.y) / 3, (a.z + b.z + c.z) / 3});
    if (!at || !(at->x >= 0 && at->y >= 0 && at->x < seen_.ivm.width && at->y < seen_.ivm.height)) return;
    const auto x = static_cast<int>(at->x), y = static_cast<int>(at->y);
    if (!excluded_.all.contains(x, y)) return;
    Lost lost;
    lost.count(excluded_, x, y);
    take_away(face, lost);
  }

  void take_away(std::size_t face, const Lost& lost) {
    --(seen_.classes[face] == FaceClass::full ? seen_.statistics.full : seen_.statistics.partial);
    seen_.classes[face] = lost.face_class();
  }

  Rest* rest_of(FaceId face) {
    const std::uint32_t number = number_[index(face)];
    return number == kNoNumber ? nullptr : &rest_[number];
  }

  void measure_full_faces() {
    for_each_pixel([&](int x, int y, FaceId face) {
      Rest* rest = rest_of(face);
      if (rest == nullptr) return;
      rest->lost.count(excluded_, x, y);
      if (!excluded_.all.contains(x, y)) rest->add(x, y);
    });
  }

  /// Anew, in face order.
  void make_coverage() {
    const CoverageTable before = std::exchange(seen_.coverage, {});
    auto entry = before.entries.begin();
    for (std::size_t f = 0; f < number_.size(); ++f) {
      Rest* rest = rest_of(FaceId{static_cast<std::uint32_t>(f)});
      if (entry != before.entries.end() && index(entry->face) == f) {
        copy(*entry++, before);
      } else if (rest != nullptr && rest->has == 0) {
        take_away(f, rest->lost);
      } else if (rest != nullptr) {
        add(f, *rest);
      }
    }
  }

  /// Of a face that was seen in part.
  void copy(const FaceCoverage& entry, const CoverageTable& from) {
    CoverageTable& coverage = seen_.coverage;
    const auto first = from.words.begin() + static_cast<std::ptrdiff_t>(entry.first_word);
    FaceCoverage copied = entry;
    copied.first_word = coverage.words.size();
    coverage.words.insert(coverage.words.end(), first, first + static_cast<std::ptrdiff_t>(word_count(entry)));
    Lost lost;
    std::uint32_t has = 0;
    for (int y = entry.y0; y < entry.y0 + entry.height; ++y)
      for (int x = entry.x0; x < entry.x0 + entry.width; ++x) {
        if (!from.sees(entry, x, y)) continue;
        lost.count(excluded_, x, y);
        if (excluded_.all.contains(x, y))
          set(coverage, copied, x, y, false);
        else
          ++has;
      }
    if (has == 0) {
      coverage.words.resize(copied.first_word);
      take_away(index(entry.face), lost);
      return;
    }
    const double share = static_cast<double>(has) / static_cast<double>(lost.had);
    copied.visible = static_cast<std::uint32_t>(std::max(1.0, share * copied.visible));
    copied.visible_share *= static_cast<float>(share);
    coverage.entries.push_back(copied);
  }

  /// Of a face that was seen in full.
  void add(std::size_t face, Rest& rest) {
    FaceCoverage entry;
    entry.face = FaceId{static_cast<std::uint32_t>(face)};
    entry.view = id_;
    entry.x0 = rest.x0;
    entry.y0 = rest.y0;
    entry.width = rest.x1 - rest.x0 + 1;
    entry.height = rest.y1 - rest.y0 + 1;
    entry.visible = rest.has;
    entry.visible_share = static_cast<float>(rest.has) / static_cast<float>(rest.lost.had);
    entry.first_word = seen_.coverage.words.size();
    seen_.coverage.words.resize(entry.first_word + word_count(entry), 0);
    rest.entry = seen_.coverage.entries.size();
    seen_.coverage.entries.push_back(entry);
    seen_.classes[face] = FaceClass::partial;
    --seen_.statistics.full;
    ++seen_.statistics.partial;
  }

  void clear_pixels() {
    const auto width = static_cast<std::size_t>(seen_.ivm.width);
    for_each_pixel([&](int x, int y, FaceId face) {
      if (excluded_.all.contains(x, y))
        seen_.ivm.faces[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] = kNoFace;
      else if (const Rest* rest = rest_of(face))
        set(seen_.coverage, seen_.coverage.entries[rest->entry], x, y, true);
    });
  }

  const Mesh& mesh_;
  const View& view_;
  ViewId id_;
  const ExcludedPixels& excluded_;
  ViewVisibility& seen_;
  std::vector<std::uint32_t> number_;  ///< per face, in rest_; kNoNumber for others than find_full_faces() finds
  std::vector<Rest> rest_;
  std::vector<bool> has_pixel_;  ///< per face
};

}  // namespace

std::size_t exclude(const Mesh& mesh, const View& view, ViewId id, const ExcludedPixels& excluded,
                    ViewVisibility& seen) {
  return Exclusion(mesh, view, id, excluded, seen).run();
}

}  // namespace gpvc::visibility
