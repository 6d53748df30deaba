#include "app/query/photos.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "io/photo_pixel.h"

namespace gpvc::query {
namespace {

using visibility::FaceClass;
using visibility::Sight;

Reason reason_of(Sight sight) {
  switch (sight) {
    case Sight::seen:
      return Reason::shown;
    case Sight::behind:
      return Reason::behind;
    case Sight::outside_frame:
      return Reason::outside_frame;
    case Sight::outside_photo:
      return Reason::outside_photo;
    case Sight::masked:
      return Reason::masked;
    case Sight::back:
      return Reason::back;
    case Sight::edge_on:
      return Reason::edge_on;
    case Sight::hidden:
      break;
  }
  return Reason::hidden;
}

Reason reason_of(labeling::ViewFate fate) {
  switch (fate) {
    case labeling::ViewFate::refused:
      return Reason::refused;
    case labeling::ViewFate::outlier:
      return Reason::outlier;
    case labeling::ViewFate::background:
      return Reason::background;
    case labeling::ViewFate::mixed:
      return Reason::mixed;
    case labeling::ViewFate::candidate:
    case labeling::ViewFate::not_needed:
      break;
  }
  return Reason::shown;
}

// Photos that show the point come first: candidates by their cost, others by the size at which they show the face.
auto rank(const PhotoOfPoint& photo) {
  const bool shows = photo.reason == Reason::shown;
  return std::tuple(!shows, shows && !photo.cost, shows && photo.cost ? photo.cost->total() : 0,
                    shows ? photo.sharpness.gsd : 0, photo.view);
}

}  // namespace

const char* words_of(Reason reason) {
  switch (reason) {
    case Reason::shown:
      return "shows it";
    case Reason::behind:
      return "behind the camera";
    case Reason::outside_frame:
      return "outside the frame";
    case Reason::outside_photo:
      return "beyond what the lens shows";
    case Reason::masked:
      return "on a masked pixel";
    case Reason::back:
      return "the surface faces away";
    case Reason::edge_on:
      return "the surface is seen from the side";
    case Reason::hidden:
      return "hidden by another face";
    case Reason::left_out:
      return "the photo agrees with no other and is left out";
    case Reason::background:
      return "photos show what lies behind in the face's place";
    case Reason::mixed:
      return "the photo shows a mixture with what lies behind";
    case Reason::refused:
      return "forbidden by a rule";
    case Reason::outlier:
      break;
  }
  return "an outlier: the photo shows another colour than the others";
}

PhotoFinder::PhotoFinder(const checks::Input& input, io::PhotoSource& photos, const pipeline::Judgement* judgement,
                         const labeling::CostOptions& costs, labeling::CandidateCollector::Allowed allowed)
    : input_(input),
      photos_(photos),
      judgement_(judgement),
      costs_(judgement != nullptr ? judgement->costs : costs),
      allowed_(std::move(allowed)),
      stage_(input.mesh) {}

PhotoOfPoint PhotoFinder::look(const visibility::SurfacePoint& point, ViewId id, labeling::FaceRecord& record) const {
  const View& view = input_.scene.views[index(id)];
  PhotoOfPoint photo;
  photo.view = id;
  visibility::PointSight sight = stage_.look(point, view, nullptr);
  visibility::FaceSight whole = stage_.classify(sight.face, view, nullptr);
  // Masks can only take away: none is read for a view that has nothing to lose.
  if (sight.sight == Sight::seen || sight.sight == Sight::back || sight.sight == Sight::hidden ||
      whole.found != FaceClass::hidden)
    if (const auto excluded = photos_.exclusion(id)) {
      sight = stage_.look(point, view, excluded.get());
      whole = stage_.classify(sight.face, view, excluded.get());
    }
  photo.reason = reason_of(sight.sight);
  photo.face = sight.face;
  photo.hidden_by = sight.hidden_by;
  if (sight.photo) photo.pixel = io::taken_pixel(view, *sight.photo);
  if (sight.sight != Sight::behind) photo.sharpness = sharpness_of(view, point.at, normal_of(input_.mesh, photo.face));
  photo.found = whole.found;
  photo.visible_share = static_cast<double>(whole.visible_share);
  record = labeling::geometric_record(input_.mesh, view, photo.face, photo.visible_share, whole.visible, costs_.term);
  return photo;
}

// What a view tells of the face that it looks at; nullopt: nothing.
std::optional<labeling::FaceRecord> PhotoFinder::record_of(const PhotoOfPoint& photo,
                                                           const labeling::FaceRecord& geometric) const {
  if (judgement_ != nullptr) return labeling::record_of(judgement_->statistics[index(photo.view)], photo.face);
  if (photo.found == FaceClass::hidden) return std::nullopt;
  return geometric;
}

// Which of the views that look at a face are its candidates, and what the others lack.
void PhotoFinder::choose(FaceId face, std::span<PhotoOfPoint> photos,
                         std::span<const labeling::FaceRecord> geometric) const {
  std::vector<labeling::ViewOfFace> views;
  std::vector<PhotoOfPoint*> with_record, without;
  for (std::size_t n = 0; n < photos.size(); ++n) {
    if (photos[n].face != face) continue;
    if (judgement_ != nullptr && !judgement_->labels.empty())
      photos[n].textures_face = judgement_->labels[index(face)] == photos[n].view;
    const std::optional<labeling::FaceRecord> record = record_of(photos[n], geometric[n]);
    (record ? with_record : without).push_back(&photos[n]);
    if (record) views.push_back({photos[n].view, *record});
  }
  const auto allowed = [&](ViewId view) { return !allowed_ || allowed_(face, view); };
  const std::vector<labeling::ViewChoice> choices = labeling::choose_views(views, costs_, allowed);
  bool background = false;
  for (std::size_t n = 0; n < views.size(); ++n) {
    PhotoOfPoint& photo = *with_record[n];
    background = background || !views[n].record.has_surface();
    if (photo.reason != Reason::shown) continue;
    photo.reason = reason_of(choices[n].fate);
    photo.doubtful = choices[n].doubtful;
    if (choices[n].fate == labeling::ViewFate::candidate) photo.cost = choices[n].cost;
  }
  for (PhotoOfPoint* photo : without) {
    if (photo->reason != Reason::shown) continue;
    if (judgement_ != nullptr && judgement_->leaves_out(photo->view))
      photo->reason = Reason::left_out;
    else if (!allowed(photo->view))
      photo->reason = Reason::refused;
    else if (judgement_ != nullptr && photo->found != FaceClass::hidden)
      // Faces lose a view's samples where its photo shows background, and all views where most photos do.
      photo->reason = background ? Reason::background : Reason::mixed;
  }
}

PointAnswer PhotoFinder::photos_of(const visibility::SurfacePoint& point) const {
  PointAnswer answer;
  answer.point = point;
  answer.photos.resize(input_.views.size());
  std::vector<labeling::FaceRecord> geometric(input_.views.size());
  tbb::parallel_for(std::size_t{0}, input_.views.size(),
                    [&](std::size_t n) { answer.photos[n] = look(point, input_.views[n], geometric[n]); });
  std::set<FaceId> faces;
  for (const PhotoOfPoint& photo : answer.photos) faces.insert(photo.face);
  for (const FaceId face : faces) choose(face, answer.photos, geometric);
  std::ranges::sort(answer.photos, {}, rank);
  answer.shown = static_cast<std::size_t>(std::ranges::count(answer.photos, Reason::shown, &PhotoOfPoint::reason));
  return answer;
}

Cutout cut_out(const Image& photo, const PhotoPoint& pixel, int size) {
  const auto side = [&](double at, int length) {
    const int first = static_cast<int>(std::floor(std::clamp(at, 0.0, static_cast<double>(length)))) - size / 2;
    return std::pair(std::clamp(first, 0, length), std::clamp(first + size, 0, length));
  };
  const auto [x0, x1] = side(pixel.x, photo.width);
  const auto [y0, y1] = side(pixel.y, photo.height);
  Cutout cut;
  cut.image.width = x1 - x0;
  cut.image.height = y1 - y0;
  cut.image.channels = photo.channels;
  for (int y = y0; y < y1; ++y) {
    const auto* row = photo.at(x0, y);
    cut.image.pixels.insert(cut.image.pixels.end(), row, row + std::ptrdiff_t{x1 - x0} * photo.channels);
  }
  cut.pixel = {pixel.x - x0, pixel.y - y0};
  return cut;
}

}  // namespace gpvc::query
