// The oracle: the definition of visibility.h taken literally. Every face is drawn into squares of the image in doubles
// with bounded error; whatever lies within a tie of an edge or of another depth is decided again without rounding. The
// bounds are in oracle_faces.h, the exact arithmetic in oracle_exact.h. Nothing is shared with the classifier.
//
// A tie matters when the class of the face depends on how it is resolved, so all possible classes of a face are
// computed beside the exact one.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "io/grouping.h"
#include "visibility/oracle.h"
#include "visibility/oracle/oracle_tile.h"

namespace gpvc::visibility {
namespace truth {
namespace {

struct Grid {
  int columns, rows;
  explicit Grid(const Camera& c)
      : columns((c.width + Tile::kSize - 1) / Tile::kSize), rows((c.height + Tile::kSize - 1) / Tile::kSize) {}
  std::size_t tiles() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  static int square(float position, int count) {
    return std::clamp(static_cast<int>(std::floor(position / Tile::kSize)), 0, count - 1);
  }
  template <class Callback>
  void for_each_touched(const FaceFacts& f, Callback&& callback) const {
    for (int y = square(f.y0, rows); y <= square(f.y1, rows); ++y)
      for (int x = square(f.x0, columns); x <= square(f.x1, columns); ++x)
        callback(static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x));
  }
};

/// What the samples of a face say: in exact arithmetic, and for every way of resolving ties.
struct Sight {
  bool sees = false, misses = false;         ///< exactly: some sample sees the face, some sample does not
  bool must_see = false, may_see = false;    ///< some sample sees it for every, for some way of resolving ties
  bool must_miss = false, may_miss = false;  ///< the same for a sample that does not see it
};

FaceClass class_of(bool sees, bool misses, bool inside) {
  if (!sees) return FaceClass::hidden;
  return inside && !misses ? FaceClass::full : FaceClass::partial;
}

std::uint8_t bit(FaceClass c) { return static_cast<std::uint8_t>(1U << static_cast<unsigned>(c)); }

/// The classes that the face has for some way of resolving ties, as bits.
std::uint8_t possible_classes(const Sight& s, Answer inside) {
  std::uint8_t classes = 0;
  if (!s.must_see) classes |= bit(FaceClass::hidden);
  if (s.may_see && !s.must_miss && inside != Answer::no) classes |= bit(FaceClass::full);
  if (s.may_see && (s.may_miss || inside != Answer::yes)) classes |= bit(FaceClass::partial);
  return classes;
}

Sight sight_of(const Tally& t) {
  Sight s;
  s.sees = t.seen + t.seen_exact > 0 || (t.on_edge & kEdgeInSeen) != 0;
  s.misses = t.members > t.seen + t.seen_exact || (t.on_edge & kEdgeInUnseen) != 0;
  s.must_see = t.seen > 0;
  s.may_see = t.seen + t.disputed > 0 || (t.on_edge & kEdgeMaySee) != 0;
  s.must_miss = t.members > t.seen + t.disputed;
  s.may_miss = t.members > t.seen || (t.on_edge & kEdgeMayMiss) != 0;
  return s;
}

/// Whether a sub-pixel sample lies in the image: `maybe` within a tie of the border. `exactly` is set to the answer
/// without ties.
Answer in_image(const Camera& c, double x, double y, bool& exactly) {
  const auto inside = [&](double px, double py) {
    return px >= 0 && py >= 0 && px <= c.width && py <= c.height && in_photo(c, {px, py});
  };
  exactly = inside(x, y);
  int count = 0;
  for (const double dx : {-kTiePx, kTiePx})
    for (const double dy : {-kTiePx, kTiePx}) count += inside(x + dx, y + dy);
  return count == 4 ? Answer::yes : count == 0 ? Answer::no : Answer::maybe;
}

/// What the four samples of a face without pixel centre say.
struct FourSamples {
  Sight sight;
  void add(const Sample& sample) {
    const bool sees = sample.in_image_exactly && !sample.hidden && !sample.beaten;
    sight.sees |= sees;
    sight.misses |= !sees;
    const bool may = sample.in_image != Answer::no && !sample.hidden;
    const bool must = may && sample.in_image == Answer::yes && !sample.disputed;
    sight.may_see |= may;
    sight.must_see |= must;
    sight.must_miss |= !may;
    sight.may_miss |= !must;
  }
};

class Oracle {
 public:
  Oracle(const Mesh& mesh, const View& view)
      : scene_{mesh, view, project_vertices(mesh, view), {}},
        grid_(view.camera),
        tallies_(mesh.faces.size()),
        centres_(mesh.faces.size(), Answer::yes),
        exact_centres_(mesh.faces.size(), 1) {
    scene_.facts.resize(mesh.faces.size());
    tbb::parallel_for(std::size_t{0}, mesh.faces.size(),
                      [&](std::size_t f) { scene_.facts[f] = face_facts(mesh, view, corners(f), f); });
  }

  OracleView run() {
    const auto faces = group_items<std::uint32_t>(grid_.tiles(), [&](const auto& add) {
      for (std::uint32_t f = 0; f < tallies_.size(); ++f)
        if (scene_.facts[f].reaches) grid_.for_each_touched(scene_.facts[f], [&](std::size_t tile) { add(tile, f); });
    });
    for_each_tile([&](std::size_t tile) { tile_at(tile)->decide_pixels(faces[tile], tallies_); });
    tbb::parallel_for(std::size_t{0}, tallies_.size(), [&](std::size_t f) { look_for_centres(f); });
    std::vector<FourSamples> four(tallies_.size());
    const std::size_t placed = decide_samples(faces, four);
    return answer(four, placed);
  }

 private:
  Corners corners(std::size_t face) const { return corners_of(scene_.mesh, scene_.vertices, face); }
  bool may_face_camera(std::size_t f) const {
    return scene_.facts[f].reaches && (scene_.facts[f].orientation < 0 || scene_.facts[f].thin);
  }
  std::unique_ptr<Tile> tile_at(std::size_t tile) const {
    const auto columns = static_cast<std::size_t>(grid_.columns);
    return std::make_unique<Tile>(scene_, static_cast<int>(tile % columns), static_cast<int>(tile / columns));
  }
  template <class Callback>
  void for_each_tile(Callback&& callback) const {
    tbb::parallel_for(std::size_t{0}, grid_.tiles(), callback);
  }

  /// Whether the projection contains a pixel centre of the frame.
  void look_for_centres(std::size_t f) {
    const Tally& tally = tallies_[f];
    if (!may_face_camera(f) || tally.members > 0) return;
    centres_[f] = tally.on_edge != 0 ? Answer::maybe : Answer::no;
    exact_centres_[f] = (tally.on_edge & kEdgeIn) != 0;
  }

  struct SampleInTile {
    std::size_t tile;
    Sample sample;
  };

  /// Nothing when the sample certainly lies outside the image.
  std::optional<SampleInTile> place(std::uint32_t face, std::uint16_t number) const {
    const Vertex point = sample_point(corners(face), number);
    if (!(point.z > 0)) return std::nullopt;  // behind the camera: not projected
    const Camera& c = scene_.view.camera;
    const auto x = static_cast<double>(point.x / point.z), y = static_cast<double>(point.y / point.z);
    SampleInTile placed{0, {face, number}};
    placed.sample.in_image = in_image(c, x, y, placed.sample.in_image_exactly);
    if (placed.sample.in_image == Answer::no) return std::nullopt;
    const int column = std::clamp(static_cast<int>(std::floor(x)), 0, c.width - 1);
    const int row = std::clamp(static_cast<int>(std::floor(y)), 0, c.height - 1);
    placed.tile = static_cast<std::size_t>(row / Tile::kSize) * static_cast<std::size_t>(grid_.columns) +
                  static_cast<std::size_t>(column / Tile::kSize);
    placed.sample.pixel = static_cast<std::uint16_t>(row % Tile::kSize * Tile::kSize + column % Tile::kSize);
    return placed;
  }

  /// Decides the sub-pixel samples of the faces that may have no pixel centre. Returns how many lie in the image.
  std::size_t decide_samples(const Grouped<std::uint32_t>& faces, std::vector<FourSamples>& four) {
    std::vector<SampleInTile> placed;
    for (std::uint32_t f = 0; f < tallies_.size(); ++f) {
      if (!may_face_camera(f) || centres_[f] == Answer::yes) continue;
      for (std::uint16_t number = 0; number < 4; ++number) {
        if (const std::optional<SampleInTile> sample = place(f, number)) {
          placed.push_back(*sample);
        } else {
          four[f].add({f, number});
        }
      }
    }
    auto samples = group_items<Sample>(grid_.tiles(), [&](const auto& add) {
      for (const SampleInTile& sample : placed) add(sample.tile, sample.sample);
    });
    for_each_tile([&](std::size_t tile) {
      if (!samples[tile].empty()) tile_at(tile)->decide_samples(faces[tile], samples[tile]);
    });
    for (const Sample& sample : samples.items) four[sample.face].add(sample);
    return placed.size();
  }

  OracleView answer(const std::vector<FourSamples>& four, std::size_t placed) const {
    OracleView view;
    view.samples = placed;
    view.classes.assign(tallies_.size(), FaceClass::hidden);
    view.tied.assign(tallies_.size(), 0);
    for (std::size_t f = 0; f < tallies_.size(); ++f) {
      if (!may_face_camera(f)) continue;
      const FaceFacts& facts = scene_.facts[f];
      const Sight pixels = sight_of(tallies_[f]);
      const Sight& exact = exact_centres_[f] != 0 ? pixels : four[f].sight;
      view.samples += tallies_[f].members;
      std::uint8_t possible = 0;
      if (centres_[f] != Answer::no) possible |= possible_classes(pixels, facts.inside);
      if (centres_[f] != Answer::yes) possible |= possible_classes(four[f].sight, facts.inside);
      if (facts.thin) possible |= bit(FaceClass::hidden);
      if (facts.orientation < 0) view.classes[f] = class_of(exact.sees, exact.misses, facts.inside_exactly);
      view.tied[f] = (possible & (possible - 1U)) != 0;
    }
    return view;
  }

  OracleScene scene_;
  Grid grid_;
  std::vector<Tally> tallies_;
  std::vector<Answer> centres_;  ///< whether the projection contains a pixel centre of the frame
  std::vector<std::uint8_t> exact_centres_;
};

}  // namespace
}  // namespace truth

OracleView oracle_visibility(const Mesh& mesh, const View& view) { return truth::Oracle(mesh, view).run(); }

}  // namespace gpvc::visibility
