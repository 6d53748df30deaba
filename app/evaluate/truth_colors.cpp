// A model's texels judged by their colours, as any program's model can be.
#include <algorithm>
#include <cmath>
#include <limits>

#include "app/evaluate/truth_score.h"
#include "io/bilinear.h"
#include "io/vector.h"

namespace gpvc::evaluate {
namespace {

constexpr int kOtherReach_px = 3;

double distance(const Pixel& a, const Pixel& b) {
  return static_cast<double>(std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])}));
}

/// The texture's colour at a point, as renderers look it up; nullopt where there is no texture.
std::optional<Pixel> texel_at(const MatchedModel& matched, const FacePoint& point) {
  const std::uint32_t face = matched.model_face[point.face];
  if (face == kNoModelFace || matched.model->face_page[face] >= matched.pages.size()) return std::nullopt;
  const auto b = static_cast<double>(point.b), c = static_cast<double>(point.c);
  const std::array<double, 3> weights{1 - b - c, b, c};
  double u = 0, v = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const io::TexCoord& t =
        matched.model->texcoords[matched.model->face_texcoords[face][matched.corners[point.face][i]]];
    u += weights[i] * static_cast<double>(t.u);
    v += weights[i] * static_cast<double>(t.v);
  }
  if (io::reaches_beyond_page(*matched.model, face)) {
    u = repeated(u);
    v = repeated(v);
  }
  const Image& page = matched.pages[matched.model->face_page[face]];
  const Rgb color = bilinear(page, u * page.width, v * page.height);
  return Pixel{static_cast<float>(color[0]), static_cast<float>(color[1]), static_cast<float>(color[2])};
}

struct Texels {
  std::vector<std::optional<Pixel>> colors;
  std::vector<double> own_distances;
  bool off(std::size_t point) const { return colors[point] && own_distances[point] > kColorTolerance; }
};

Texels find_texels(const TruthPoints& points, const MatchedModel& model) {
  Texels texels{std::vector<std::optional<Pixel>>(points.seen.size()), std::vector<double>(points.seen.size(), 0)};
  for_each_point(points.seen.size(), [&](std::size_t i) {
    texels.colors[i] = texel_at(model, points.seen[i]);
    if (texels.colors[i]) texels.own_distances[i] = points.own_distance(i, *texels.colors[i]);
  });
  return texels;
}

/// Per seen point whose texel is off its own colours: the distance to the nearest colour of another surface that a used
/// photo shows around it.
std::vector<double> other_distances(const TruthInput& input, const ShownPhotos& photos, const TruthPoints& points,
                                    const Texels& texels, const Progress& progress) {
  std::vector<double> others(points.seen.size(), std::numeric_limits<double>::infinity());
  for (std::size_t n = 0; n < input.used.size(); ++n) {
    const ShownPhoto photo = photos.photo(input.used[n]);
    for_each_point(points.seen.size(), [&](std::size_t i) {
      if (!texels.off(i)) return;
      const auto at = photo.project(position_of(input.truth.mesh, points.seen[i]));
      if (!at) return;
      const std::uint32_t surface = input.truth.face_surface[points.seen[i].face];
      photo.around(*at, kOtherReach_px, [&](int x, int y) {
        const std::uint32_t shown = photo.surface(x, y);
        if (shown == surface || shown == synth::kMixedSurfaces) return;
        const Pixel color = photo.color(x, y), &t = *texels.colors[i];
        for (const float g : points.gains)
          others[i] = std::min(others[i], distance(color, {t[0] * g, t[1] * g, t[2] * g}));
      });
    });
    progress(n + 1, input.used.size());
  }
  return others;
}

/// 0: some used view sees the face fully, 1: only partially, 2: none.
std::size_t kind_of(visibility::FaceClass best) {
  return best == visibility::FaceClass::full ? 0 : best == visibility::FaceClass::partial ? 1 : 2;
}

void count_faces(const Mesh& mesh, const std::vector<visibility::FaceClass>& best, const MatchedModel& model,
                 TruthScore& score) {
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const std::size_t kind = kind_of(best[f]);
    const double area = length(twice_area_normal(mesh, f)) / 2;
    score.all.area += area;
    if (kind < 2) (kind == 0 ? score.full : score.partial).area += area;
    ++score.faces[kind];
    const std::uint32_t g = model.model_face[f];
    if (g != kNoModelFace && model.model->face_page[g] < model.pages.size()) ++score.textured[kind];
  }
}

/// Turns sums of areas into shares.
void divide(TruthShares& shares) {
  const double textured = shares.textured;
  for (double* part : {&shares.wrong, &shares.unexplained, &shares.undetectable})
    *part = textured > 0 ? *part / textured : 0;
  shares.textured = shares.seen_area > 0 ? textured / shares.seen_area : 0;
}

}  // namespace

TruthScore TruthScorer::score(const MatchedModel& model, const Progress& progress) const {
  const Texels texels = find_texels(points_, model);
  const std::vector<double> others = other_distances(input_, photos_, points_, texels, progress);
  TruthScore score;
  score.samples = points_.seen.size();
  score.light = light_of(input_.truth.mesh, points_, texels.colors);
  count_faces(input_.mesh, points_.best, model, score);
  for (std::size_t i = 0; i < points_.seen.size(); ++i) {
    const auto& [face, b, c, area] = points_.seen[i];
    const bool off = texels.off(i), wrong = off && others[i] < texels.own_distances[i];
    if (wrong && (score.wrong_faces.empty() || score.wrong_faces.back() != face)) score.wrong_faces.push_back(face);
    for (TruthShares* shares : {&score.all, kind_of(points_.best[face]) == 0 ? &score.full : &score.partial}) {
      shares->seen_area += area;
      if (!texels.colors[i]) continue;
      shares->textured += area;
      shares->wrong += wrong ? area : 0;
      shares->unexplained += off && !wrong ? area : 0;
      shares->undetectable += area * static_cast<double>(points_.undetectable[i]);
    }
  }
  for (TruthShares* shares : {&score.all, &score.full, &score.partial}) divide(*shares);
  return score;
}

}  // namespace gpvc::evaluate
