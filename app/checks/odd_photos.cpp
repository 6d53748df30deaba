#include "app/checks/odd_photos.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "app/checks/framing.h"
#include "io/vector.h"

namespace gpvc::checks {
namespace {

/// A view and those that stand nearest to it, whose photos agree with each other.
struct Surroundings {
  Scene scene;  ///< of these views, the view first
  Mesh mesh;    ///< some faces in its frame
  std::vector<SmallPhoto> photos;
  std::vector<Place> places;  ///< that it sees

  /// The places at which a photo taken there agrees with the others. Borrows this for the time being.
  double agreeing(SmallPhoto photo) {
    photos[0] = std::move(photo);
    const MeshFit fit = measure_fit(mesh, scene, photos, places);
    // Chance alone finds a surface at one place in twenty.
    constexpr double kLeastFound = 0.1, kLeastShare = 0.5;
    const bool more_than_chance = static_cast<double>(fit.found) >= kLeastFound * static_cast<double>(fit.places);
    return more_than_chance && fit.share >= kLeastShare ? places_on_mesh(fit) : 0;
  }
};

Surroundings surroundings_of(const Input& input, std::span<const SmallPhoto> photos, ViewId view,
                             std::span<const ViewId> odd) {
  constexpr std::size_t kNearest = 8, kFaces = 8192;
  const View& at = input.scene.views[index(view)];
  std::vector<std::pair<double, ViewId>> others;
  for (const ViewId other : input.views)
    if (other != view && !photos[index(other)].image.pixels.empty() && !std::ranges::binary_search(odd, other))
      others.emplace_back(length(input.scene.views[index(other)].pose.centre - at.pose.centre), other);
  std::ranges::sort(others);
  others.resize(std::min(others.size(), kNearest));
  Surroundings around{{}, some_faces(input.mesh, kFaces, &at), {}, {}};
  around.scene.views.push_back(at);
  around.photos.push_back(photos[index(view)]);
  for (const auto& [distance, other] : others) {
    around.scene.views.push_back(input.scene.views[index(other)]);
    around.photos.push_back(photos[index(other)]);
  }
  around.places = framed_places(around.mesh, around.scene, around.photos);
  std::erase_if(around.places, [](const Place& place) { return index(place.a) != 0 && index(place.b) != 0; });
  return around;
}

/// What people exchange: photos that agree with no others, and those that follow each other.
std::vector<ViewId> views_to_try(std::span<const ViewId> views, ViewId photo, std::span<const ViewId> odd) {
  constexpr std::ptrdiff_t kBeside = 3;
  std::vector<ViewId> tried(odd.begin(), odd.end());
  const auto at = std::ranges::find(views, photo) - views.begin();
  const auto end = std::min(std::ssize(views), at + kBeside + 1);
  for (auto i = std::max<std::ptrdiff_t>(0, at - kBeside); i < end; ++i)
    tried.push_back(views[static_cast<std::size_t>(i)]);
  std::ranges::sort(tried);
  tried.erase(std::unique(tried.begin(), tried.end()), tried.end());
  std::erase(tried, photo);
  return tried;
}

class Explainer {
 public:
  Explainer(const Input& input, std::span<const SmallPhoto> photos, std::span<const ViewId> odd)
      : input_(input), photos_(photos), odd_(odd) {}

  /// Empty: nothing that is tried explains it.
  std::string explain(ViewId view) {
    constexpr double kLeast = 12, kClearly = 3;
    const SmallPhoto& photo = photos_[index(view)];
    if (photo.image.pixels.empty()) return {};
    const View& odd = input_.scene.views[index(view)];
    const std::string& name = odd.name;
    for (const ViewId other : input_.views)  // several views of a panorama show one file
      if (input_.scene.views[index(other)].photo != odd.photo &&
          photos_[index(other)].image.pixels == photo.image.pixels)
        return fmt::format("{} shows the same as {}", name, input_.scene.views[index(other)].name);
    Surroundings& here = at(view);
    const double least = std::max(kLeast, kClearly * here.agreeing(photo));
    double best = 0;
    std::string text;
    const auto offer = [&](double agreeing, const std::string& clause) {
      if (agreeing >= least && agreeing > best) {
        best = agreeing;
        text = clause;
      }
    };
    const std::string turned = name + " would agree if it were turned by 180 degrees";
    offer(here.agreeing(turned_over(photo)), turned);
    // A principal point off the middle is in its place for one of the two.
    View& pose = here.scene.views[0];
    const View as_is = pose;
    for (std::size_t i = 0; i < 6; ++i) pose.pose.rotation[i] = -pose.pose.rotation[i];
    offer(here.agreeing(photo), turned);
    pose = as_is;
    offer(here.agreeing(mirrored(photo)), name + " would agree if it were mirrored");
    for (const ViewId other : views_to_try(input_.views, view, odd_)) {
      const Image& own = photos_[index(other)].image;
      if (own.width != photo.image.width || own.height != photo.image.height) continue;
      offer(at(other).agreeing(photo),
            fmt::format("{} shows what {}'s camera sees", name, input_.scene.views[index(other)].name));
    }
    return text;
  }

 private:
  Surroundings& at(ViewId view) {
    const auto found = around_.find(view);
    return found != around_.end() ? found->second
                                  : around_.emplace(view, surroundings_of(input_, photos_, view, odd_)).first->second;
  }

  const Input& input_;
  std::span<const SmallPhoto> photos_;
  std::span<const ViewId> odd_;
  std::map<ViewId, Surroundings> around_;
};

}  // namespace

std::vector<std::string> explain_photos(const Input& input, std::span<const SmallPhoto> photos,
                                        std::span<const ViewId> odd, results::Observer& observer) {
  constexpr std::size_t kMost = 4;
  Explainer explainer(input, photos, odd);
  std::vector<std::string> clauses;
  for (const ViewId view : odd.first(std::min(kMost, odd.size()))) {
    observer.check_cancelled();
    if (std::string clause = explainer.explain(view); !clause.empty()) clauses.push_back(std::move(clause));
  }
  return clauses;
}

}  // namespace gpvc::checks
