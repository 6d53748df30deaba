// What a synthetic scene is known to show, and how much of a textured model agrees with it.
//
// A scene's folder DIR holds, besides photos, cameras and mesh.ply:
//   surfaces.npy   per face of mesh.ply, its surface
//   surfaces.json  per surface its material, frame and seed
//   truth.json     gains of the photos
//   true_mesh.ply  where mesh.ply was written with noise: the geometry that the photos show
//   ids/NAME.png   per photo, the surface that each pixel shows, as a colour of its own (id_color)
//   unmodelled/NAME.png  where photos show what the mesh lacks: which share of each pixel it covers, 255 being all
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/synth/synth_scene.h"
#include "atlas/atlas.h"
#include "io/photos.h"
#include "io/progress.h"
#include "io/scene.h"
#include "io/textured_model.h"
#include "visibility/result.h"

namespace gpvc::evaluate {

/// A colour for each surface below 2^20 and for kMixedSurfaces (white) and kNoSurface (black), far apart for near
/// numbers.
std::array<std::uint8_t, 3> id_color(std::uint32_t surface);
/// The inverse; kMixedSurfaces for colours that belong to no surface below `surfaces`.
std::uint32_t surface_of_color(const std::uint8_t* rgb, std::size_t surfaces);

struct Truth {
  std::filesystem::path dir;
  Mesh mesh;                                         ///< true geometry, in the coordinates of the scene's files
  std::vector<std::uint32_t> face_surface;           ///< per face, of mesh.ply too
  std::size_t surfaces = 0;                          ///< of the mesh; what it lacks has numbers from here on
  std::size_t all_surfaces = 0;                      ///< that included
  bool unmodelled = false;                           ///< unmodelled/ is there
  double least_gain = 1, most_gain = 1;              ///< of photo pixels, vignetting included
  std::map<std::string, synth::Exposure> exposures;  ///< by photo
};

/// Throws InputError.
Truth read_truth(const std::filesystem::path& dir);

/// The id picture of a photo, at the photo's size: per pixel a surface, kMixedSurfaces or kNoSurface. Throws
/// InputError.
std::vector<std::uint32_t> read_id_picture(const Truth& truth, const std::string& view, int width, int height);

/// Per pixel of a photo the share that unmodelled objects cover, in each channel, at the photo's size. \pre
/// truth.unmodelled. Throws InputError.
Image read_unmodelled_picture(const Truth& truth, const std::string& view, int width, int height);

/// Per face of the given mesh, the best class that any used view has, by the exact oracle.
std::vector<visibility::FaceClass> best_classes(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used,
                                                const Progress& progress);

/// A textured model brought together with the faces of the mesh that was to be textured. A face is found by its three
/// corners, so that models of programs that drop, split or reorder faces are found too.
struct MatchedModel {
  const io::TexturedModel* model = nullptr;  ///< borrowed; its mesh need not be the given one
  std::span<const Image> pages;              ///< borrowed
  std::vector<std::uint32_t> model_face;     ///< per face of the given mesh; kNoModelFace where there is none
  /// Per face: which corner of the model's face is the given face's first, second and third.
  std::vector<std::array<std::uint8_t, 3>> corners;
  std::size_t unmatched_faces = 0;  ///< faces of the model that are none of the given mesh's
};
inline constexpr std::uint32_t kNoModelFace = 0xFFFFFFFFu;

/// `offset` is added to the model's positions. Corners may differ by what rounding to six printed digits or to floats
/// does to the model's numbers, as long as that is below a 4096th of the mesh's extent.
MatchedModel match_model(const Mesh& mesh, const io::TexturedModel& model, std::span<const Image> pages,
                         const WorldPoint& offset);

/// Shares of one kind of faces, by area. A point of a face is seen when a used photo shows it and the 4 x 4 pixels
/// around it show no other surface. Its own colours are those between the least and the most, channel by channel, that
/// these photos show within 2 px of it. A texel that lies more than kColorTolerance grey levels outside of them is wrong
/// when some used photo shows, within 3 px of where the point would be, a colour of another surface that is nearer to
/// the texel than its own colours; otherwise it is unexplained.
struct TruthShares {
  double area = 0;         ///< of the faces
  double seen_area = 0;    ///< that some used photo shows clear of any other surface
  double textured = 0;     ///< of the seen area
  double wrong = 0;        ///< of the textured seen area: it carries another surface's colour
  double unexplained = 0;  ///< of it: off its own colours, and near no colour that photos show there
  /// Of the photos that show another surface in a point's place, those whose colour happens to match the point's own:
  /// the share of wrong texture that this measure misses.
  double undetectable = 0;
};

/// Twice the rounding of JPEG photos and pages at quality 95 (tables of up to 10 levels a coefficient: 5 off in each of
/// two encodings) and what levelling of seams leaves.
inline constexpr double kColorTolerance = 16;

/// How far brightness and tint of a model wander off the truth, once one gain per channel for the whole model is removed: in squares of
/// a twentieth of the ground's longer edge, by the medians of the texels' ratios to the mean of their own colours.
struct TruthLight {
  std::size_t places = 0;                          ///< squares with enough points
  double brightness_worst = 0, brightness_95 = 0;  ///< as shares: the worst square, and what 95 % of them stay below
  double tint_worst = 0, tint_95 = 0;              ///< the channel that is farthest off the mean of the three
};

struct TruthScore {
  TruthLight light;
  TruthShares all, full, partial;          ///< faces some used view sees fully; only partially
  std::array<std::size_t, 3> faces{};      ///< by best class: full, partial, neither
  std::array<std::size_t, 3> textured{};   ///< faces of each that the model textures
  std::size_t samples = 0;                 ///< seen points
  std::vector<std::uint32_t> wrong_faces;  ///< faces with a wrong point, ascending
};

/// Where the texture takes its colour from at A + b (B - A) + c (C - A) of a face; nullopt where that is not known.
using OriginOf = std::function<std::optional<atlas::PointOrigin>(std::uint32_t face, double b, double c)>;

/// What the photos show where a texture was taken from. No colours are compared: the id pictures name the surfaces of
/// every pixel of a photo. A point is
/// - filled where no photo gives it a colour;
/// - wrong where the pixel it comes from shows another surface alone, and none of the four pixels around its place in
///   the photo shows its own;
/// - an edge where one of these four shows another surface and it is not wrong: up to a pixel from its own surface's
///   outline, where any resampling blends;
/// - else right. Where two photos are blended, the worse counts.
/// Points are seen ones (see TruthShares) and hidden ones: no ray from a used photo meets these, so no photo can give
/// them a colour, and a colour they take from another surface is a ghost. Points that are neither lie within pixels of
/// an outline in every photo and are left out.
struct OriginShares {
  double seen_area = 0;  ///< of the points whose origin is known
  double photo = 0;      ///< of it, textured from a photo; the rest is filled
  double right = 0;      ///< of it, textured from a photo and not wrong: edges included
  double wrong = 0;      ///< of the seen area textured from photos
  double edge = 0;       ///< of the seen area textured from photos
  /// Of the seen area textured from photos: the share that cars, people and other objects that the mesh lacks cover in the
  /// pixels it comes from, however small they are; 0 where that is not known (Truth::unmodelled).
  double unmodelled = 0;
  double unknown = 0;       ///< of the seen area: whose origin is not known, left out of all others
  double hidden_area = 0;   ///< of the points that no photo sees and whose origin is known
  double hidden_photo = 0;  ///< of the hidden area: textured from a photo
  double ghost = 0;         ///< of the hidden area: textured from another surface's pixels
  /// Of all area textured from photos, seen or hidden: textured from another surface's pixels.
  double foreign = 0;
  /// Of all area, seen or hidden: textured as it should be: from pixels of its own surface where it is seen, and not
  /// from another surface's where it is hidden.
  double faithful = 0;
};

struct WrongPoint {
  std::uint32_t face = 0;
  ViewId view{};
  PhotoPoint at;                              ///< where in its photo the point took its colour
  std::uint32_t surface = synth::kNoSurface;  ///< what is there instead
};

struct OriginScore {
  OriginShares all, full, partial, none;  ///< faces some used view sees fully; only partially; not at all
  std::vector<float> right_area;          ///< per face, of its seen area
  std::vector<float> faithful_area;       ///< per face, of its seen and its hidden area
  std::vector<WrongPoint> wrong;          ///< by face, seen points alone
};

/// The origins of faces textured from one photo each, by their exact projection into it: what our labels.npy and
/// tags.npy say of faces tagged seen. Unseen faces have none; for faces pieced together from several photos the origin
/// is not known. Borrows the mesh and the scene. \pre one label and tag per face
OriginOf origins_of_labels(const Mesh& mesh, const Scene& scene, std::vector<std::int32_t> labels,
                           std::vector<std::uint8_t> tags);

}  // namespace gpvc::evaluate
