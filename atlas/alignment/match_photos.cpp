#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "atlas/alignment/alignment.h"
#include "atlas/alignment/place_patches.h"
#include "atlas/charts/charts.h"
#include "atlas/sampling/each_photo.h"
#include "io/vector.h"

namespace gpvc::atlas {

namespace {

/// Edge, in pixels, of the squares of a frame that have one place each: some four in a cell of a field of a 12-megapixel photo.
constexpr double kPlaceSpacing = 64;
/// So many tell of a field's nodes in all photos; beyond, places are left out evenly.
constexpr std::size_t kMostPlaces = 1 << 17;
/// Bytes that a place takes, and the least that are compared at a time.
constexpr std::size_t kPlaceBytes = 5000, kLeastBatch = 256;

/// Of the views that see the face, other than the reference, the best ones.
ComparedPlace compared_place(const AtlasInput& input, const SurfacePlace& on) {
  const auto views = input.candidates.views_of(on.face);
  const auto costs = input.candidates.costs_of(on.face);
  std::vector<std::pair<float, std::uint32_t>> others;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (views[i] != index(on.reference)) others.emplace_back(costs[i], views[i]);
  std::ranges::sort(others);
  ComparedPlace place{on, {}, std::min(others.size(), ComparedPlace::kMostOthers)};
  for (std::size_t i = 0; i < place.count; ++i) place.others[i] = ViewId{others[i].second};
  return place;
}

/// Per view the faces that are textured from it and seen by another one as well.
Grouped<std::uint32_t> faces_to_match(const AtlasInput& input) {
  return group_items<std::uint32_t>(input.scene.views.size(), [&](const auto& add) {
    for (std::uint32_t face = 0; face < input.mesh.faces.size(); ++face) {
      if (input.labels[face] == kNoView || input.tags[face] != labeling::FaceTag::seen) continue;
      if (!input.border.empty() && input.border[face] != 0) continue;
      if (input.candidates.views_of(face).size() > 1) add(index(input.labels[face]), face);
    }
  });
}

/// In each square of the view's frame, of the faces the one whose middle is nearest to the square's; row-major.
std::vector<SurfacePlace> places_of_view(const AtlasInput& input, ViewId id, std::span<const std::uint32_t> faces) {
  const View& view = input.scene.views[index(id)];
  struct Nearest {
    SurfacePlace place;
    double distance2 = std::numeric_limits<double>::infinity();
  };
  const auto squares = [](int edge) { return static_cast<int>(edge / kPlaceSpacing) + 1; };
  const int columns = squares(view.camera.width), rows = squares(view.camera.height);
  std::vector<Nearest> nearest(pixel_index(0, rows, columns));
  for (const std::uint32_t face : faces) {
    const auto at = pixel_from_world(view, middle_of(input.mesh, face));
    if (!at || !is_in_frame(view.camera, *at)) continue;
    const int column = static_cast<int>(at->x / kPlaceSpacing), row = static_cast<int>(at->y / kPlaceSpacing);
    const double x = at->x / kPlaceSpacing - column - 0.5, y = at->y / kPlaceSpacing - row - 0.5;
    Nearest& found = nearest[pixel_index(column, row, columns)];
    if (x * x + y * y < found.distance2) found = {{id, *at, face}, x * x + y * y};
  }
  std::vector<SurfacePlace> places;
  for (const Nearest& found : nearest)
    if (std::isfinite(found.distance2)) places.push_back(found.place);
  return places;
}

/// A place in each square of the views' frames, by view.
std::vector<ComparedPlace> places_to_match(const AtlasInput& input) {
  const Grouped<std::uint32_t> faces = faces_to_match(input);
  std::vector<std::vector<SurfacePlace>> of_views(faces.groups());
  tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(of_views.size()),
                    [&](std::uint32_t v) { of_views[v] = places_of_view(input, ViewId{v}, faces[v]); });
  std::vector<SurfacePlace> found;
  for (const std::vector<SurfacePlace>& places : of_views) found.insert(found.end(), places.begin(), places.end());
  std::vector<ComparedPlace> places;
  const std::size_t stride = found.size() / kMostPlaces + 1;
  for (std::size_t i = 0; i < found.size(); i += stride) places.push_back(compared_place(input, found[i]));
  return places;
}

std::optional<PhotoMatch> match_of(const AtlasInput& input, const ComparedPlace& place, const PlaceComparison& one) {
  if (!one.shift) return std::nullopt;
  const ViewId other = place.others[one.other];
  const auto point = point_on_face(input.mesh, input.scene, place.on);
  const auto at = point ? pixel_from_world(input.scene.views[index(other)], *point) : std::nullopt;
  const auto change = other_from_reference(input.mesh, input.scene, place.on, other);
  if (!at || !change || !inverse(*change)) return std::nullopt;
  const auto as_float = [](double value) { return static_cast<float>(value); };
  PhotoMatch match;
  match.views = {static_cast<std::uint32_t>(index(place.on.reference)), static_cast<std::uint32_t>(index(other))};
  match.at = {as_float(place.on.at.x), as_float(place.on.at.y), as_float(at->x), as_float(at->y)};
  match.shift = {as_float(one.shift->x), as_float(one.shift->y)};
  std::ranges::transform(one.shift->information, match.information.begin(), as_float);
  std::ranges::transform(*change, match.second_from_first.begin(), as_float);
  return is_sound(match, input.scene) ? std::optional(match) : std::nullopt;
}

void add_matches(const AtlasInput& input, std::span<const ComparedPlace> places, PlacePatches& patches,
                 std::vector<PhotoMatch>& matches) {
  struct Work {
    bool is_needed = false;
    bool empty() const { return !is_needed; }
  };
  std::vector<Work> work(input.scene.views.size());
  for (std::uint32_t v = 0; v < work.size(); ++v) work[v].is_needed = patches.needs(ViewId{v});
  const auto fetch = [&](ViewId id) { return input.photos.coarse(id); };
  each_fetched(work, PhotoOrder::ascending, fetch,
               [&](ViewId id, const std::shared_ptr<const Image>& means, const Work&) { patches.take(id, *means); });
  for (const PlaceComparison& one : patches.compare())
    if (const auto match = match_of(input, places[one.place], one)) matches.push_back(*match);
}

}  // namespace

std::vector<PhotoMatch> match_photos(const AtlasInput& input, const FaceNeighbours& neighbours, const CutPlaces& cuts,
                                     std::size_t bytes) {
  // What lies on cuts is what one sees: there photos are compared more closely.
  std::vector<ComparedPlace> places = places_to_match(input);
  places.insert(places.end(), cuts.places.begin(), cuts.places.end());
  std::vector<PhotoMatch> matches;
  for (std::span<const ComparedPlace> left = places; !left.empty();) {
    const std::size_t count = std::min(left.size(), std::max(kLeastBatch, bytes / kPlaceBytes));
    const auto batch = left.first(count);
    left = left.subspan(count);
    // The cuts of a batch are the last of its places.
    const std::size_t cuts_left = std::min(left.size(), cuts.places.size());
    const std::size_t on_cuts = std::min(count, cuts.places.size() - cuts_left);
    const auto shared = std::span(cuts.surfaces).last(on_cuts + cuts_left).first(on_cuts);
    PlacePatches patches(input, batch, find_surfaces(input, neighbours, batch.first(count - on_cuts)), shared);
    add_matches(input, batch, patches, matches);
  }
  return matches;
}

std::vector<PhotoMatch> match_photos(const AtlasInput& input) {
  const FaceNeighbours neighbours = group_neighbours(input.mesh.faces.size(), input.graph.edges);
  return match_photos(input, neighbours, cut_places(input, neighbours), kMatchBytes);
}

}  // namespace gpvc::atlas
