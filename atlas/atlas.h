// From one view per face to texture pages: charts, packing, seam leveling, baking.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <future>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "../io/members.h"
#include "../io/names.h"
#include "../io/photos.h"
#include "../io/progress.h"
#include "../io/scene.h"
#include "../io/textured_model.h"
#include "../io/uv_layout.h"
#include "../io/work_store.h"
#include "../labeling/labeling.h"
#include "../visibility/result.h"
#include "photo_alignment.h"

namespace gpvc::atlas {

/// none: colours as photographed. global: one exposure per view, and offsets that fade away from seams. full: the same,
/// and what still steps along a seam is blended over a narrow strip on both sides.
enum class SeamLeveling { none, global, full };
inline constexpr Named<SeamLeveling> kSeamLevelingNames[] = {
    {"none", SeamLeveling::none}, {"global", SeamLeveling::global}, {"full", SeamLeveling::full}};

/// none: a face shows its photo alone. coarse: its photo gives the fine detail; what is coarser than some four pixels comes
/// to six tenths from the mean of all views that see the place whole, weighed by how well they do. So photos differ less in
/// brightness along seams, and errors of poses and mesh average out, while detail stays as sharp as in the photo.
enum class Blending { none, coarse };
inline constexpr Named<Blending> kBlendingNames[] = {{"none", Blending::none}, {"coarse", Blending::coarse}};

/// How unseen faces, those without a view, are textured. fill: colours continued from around the hole. drop: as fill,
/// and writers leave the faces out of formats that need not contain every face. color: one colour. Faces in whose place photos
/// show background are left out by any of them.
enum class UnseenFaces { fill, drop, color };
inline constexpr Named<UnseenFaces> kUnseenFacesNames[] = {
    {"fill", UnseenFaces::fill}, {"drop", UnseenFaces::drop}, {"color", UnseenFaces::color}};

/// True for faces that are left out of formats that need not contain every face.
constexpr bool is_dropped(UnseenFaces unseen, labeling::FaceTag tag) {
  return tag == labeling::FaceTag::background || (unseen == UnseenFaces::drop && tag == labeling::FaceTag::unseen);
}

struct AtlasOptions {
  int page_size = 8192;  ///< largest page edge, texels; pages are cropped to their content
  /// Texels around a chart that repeat its colours. Pages are divided into blocks whose edge is the largest power of
  /// two up to the padding, and no two charts share a block: with a padding of 8, mip levels down to 1/8 mix no charts.
  int padding = 8;
  PhotoAlignment align = PhotoAlignment::local;
  SeamLeveling seams = SeamLeveling::full;
  /// Multiply bands that are quantities (BandSet::radiometric), which are left as photos have them else, by one gain per view and band,
  /// and by what undoes the fall-off of the lens, so that they agree along seams.
  bool band_gains = false;
  Blending blend = Blending::coarse;
  /// Views that cost this much or more have no share in blending; below it, the share grows linearly as the cost falls.
  /// By default twice the weight of the data term (labeling::CostOptions): a view of little quality has half the share of
  /// the best one, but one along silhouettes, or with a quarter of the best one's quality, has none.
  double blend_cost = 0.1;
  /// Texels of partial faces prefer views in which nothing hides the face within this many pixels, because photo and
  /// mesh disagree by a few pixels along silhouettes.
  int margin_px = 3;
  /// Smallest edge of a texel in world units; 0: no limit. Charts with finer texels are reduced in steps of an eighth
  /// of an octave, never below the density that this asks for.
  double texel_size = 0;
  /// Limits on the number of pages and on their texels after cropping; 0: no limit. All charts are reduced by one
  /// factor to meet them.
  std::size_t max_pages = 0, max_texels = 0;
  UnseenFaces unseen = UnseenFaces::fill;
  std::array<std::uint8_t, 3> unseen_color{128, 128, 128};
};

/// How much of a texture has a colour beyond those of the photos of the place (benchmarks/README.md "Invented colour"), by the area of
/// some faces that several photos are blended on.
struct InventedColor {
  static constexpr float kTolerance = 8;  ///< grey levels by which a channel may leave their range
  std::uint64_t texels = 0, outside = 0;  ///< of the faces looked at, of those with such a colour
  void add(const InventedColor& other) {
    texels += other.texels;
    outside += other.outside;
  }
  double share() const { return texels == 0 ? 0 : static_cast<double>(outside) / static_cast<double>(texels); }
};

struct AtlasStatistics {
  std::size_t charts = 0, pages = 0;
  std::size_t filled_faces = 0;   ///< unseen ones
  std::size_t blended_faces = 0;  ///< with coarse colours of several photos, all over or in part
  std::size_t chart_texels = 0;   ///< inside charts, without padding
  std::size_t padded_texels = 0;  ///< inside charts or within the padding of one, each counted once
  std::size_t page_texels = 0;    ///< of all pages after cropping
  std::size_t seam_edges = 0;     ///< mesh edges between faces of different views, those of the border included
  /// Mean difference across these edges in grey levels (0..255). Zero, because not measured, with SeamLeveling::none.
  double seam_step_before = 0, seam_step_after = 0;
  /// Mean difference of the photos on both sides (CIEDE2000), as they are and with their exposure corrected. Zero likewise.
  double photo_misfit = 0, photo_misfit_exposed = 0;
  InventedColor invented_color{};   ///< of pages that this run painted
  CutMisfit cuts{};                 ///< zeros with SeamLeveling::none
  AlignmentStatistics alignment{};  ///< zeros with PhotoAlignment::none
  double reduction = 1;             ///< factor on the scale of all charts that meets the limits
  double layout_s = 0, alignment_s = 0, leveling_s = 0, baking_s = 0;
  std::size_t kept_pages = 0;  ///< taken from another run
  /// Photos that were decoded for seams and to paint, each as often as it was: see io::PhotoSource::decodes.
  std::size_t seam_decodes = 0, paint_decodes = 0;
};

/// Exposure of a view. Leveling multiplies a colour at distance r from the centre, 1 being half the diagonal, by the
/// gain of its channel and by exp(k1 r^2 + k2 r^4), which undoes the fall-off towards the corners, within [1/4, 4].
struct ViewExposure {
  std::array<float, 3> gain{1, 1, 1};
  double centre_x = 0, centre_y = 0, inverse_radius2 = 0;  ///< of half the diagonal; px of the undistorted frame
  double k1 = 0, k2 = 0;                                   ///< equal for all views of a camera
};
GPVC_MEMBERS(ViewExposure, gain, centre_x, centre_y, inverse_radius2, k1, k2)
/// True if the exposure can be applied: all numbers are finite, the gains above 0 and at most 2.5, inverse_radius2 >= 0.
bool is_sound(const ViewExposure& exposure);

/// The samples of a finished page, of its image's size.
struct PageSamples {
  Samples samples;  ///< in the units of the photos, all bands of AtlasInput::photos
  std::vector<std::uint8_t>
      charts{};  ///< per texel: 255 in charts, 0 beside them, where there are copies of their border, or 0
};

struct TextureAtlas {
  io::TexturedModel model;   ///< every input face has texture coordinates; those of the border have io::kNoPage instead
  std::vector<Image> pages;  ///< RGB; none where BakeOptions::take_page took them
  std::vector<PageSamples>
      samples;  ///< per page; none where photos have no bands, or BakeOptions::take_samples took them
  AtlasStatistics statistics;
  std::vector<std::uint32_t>
      face_chart;                      ///< per face, the number of its chart; AtlasStatistics::charts or more: border
  std::vector<ViewExposure> exposure;  ///< per view, as leveling has fitted or taken it; empty without leveling
  std::vector<ShiftField> alignment;   ///< per view, as fitted or taken; empty with PhotoAlignment::none
};

/// The texture of an earlier result of the same mesh and views, of which a part is made anew.
struct FinishedTexture {
  const io::TexturedModel& model;
  /// By number. Those that faces beside the new ones do not use may be empty.
  std::span<const Image> pages;
  double reduction = 1;  ///< AtlasStatistics::reduction of that result, with which new charts are made, too
  std::span<const Samples> samples = {};  ///< as pages, where photos have bands
};

/// What the atlas is made from. Borrows everything.
struct AtlasInput {
  const Mesh& mesh;
  const Scene& scene;
  io::PhotoSource& photos;
  const labeling::FaceGraph& graph;
  std::span<const ViewId> labels;           ///< per face; kNoView: unseen
  std::span<const labeling::FaceTag> tags;  ///< per face
  /// Of partial faces: the views that may contribute texels. Of others: the views to blend. Of all faces, which may have none.
  const labeling::CostTable& candidates;
  const visibility::CoverageTable& coverage;  ///< which pixels of those views see the partial faces
  /// Per face, 1 for faces of the border: neighbours of the faces to be textured, which get no texels and no texture
  /// coordinates; glTF files leave them out, OBJ files if asked. They take part in leveling like any face, so runs over
  /// neighbouring parts of a mesh agree along the seam between them if each is given the other's faces near it, with
  /// the other's labels, tags, candidates and coverage. Offsets reach 48 edges, and fade by a factor of e over 32. Unseen and
  /// partial faces are not filled from the border. Empty: no border.
  std::span<const std::uint8_t> border = {};
  /// Per view, used instead of an exposure fitted from the seams of this input, so that parts of a mesh get the same
  /// one; see fit_exposure. Each must be sound. Without effect with SeamLeveling::none. Empty: fitted.
  std::span<const ViewExposure> exposure = {};
  /// Not null: faces of the border have these colours already. Leveling leaves them as they are and brings the others to
  /// them, also where both show the same view; their photos are not read for it. Partial and unseen faces are filled from
  /// them, too. Limits on pages and texels are not looked at.
  const FinishedTexture* finished = nullptr;
  /// Per face, the number of its tile: charts and pages hold faces of one tile alone, and pages ascend by tile, so that each
  /// tile has textures of its own. Leveling works across tiles. Empty: all faces are of one.
  std::span<const std::uint32_t> tile = {};
  /// Per view, used instead of fields fitted to the photos of this input, so that parts of a mesh get the same ones; see
  /// match_photos. Each must be sound. Empty: fitted, with PhotoAlignment::local.
  std::span<const ShiftField> alignment = {};
  /// Not null: where the faces lie on pages, which are of given sizes. Each face shows its photo there; texels belong to the face
  /// which has its middle or, where none has it, touches it; of several to one that is seen whole. Faces without texture
  /// coordinates, or with such that have no area, take part in leveling alone. Not with `tile` or `finished`, nor with limits of
  /// pages, texels and texel sizes.
  const io::UvLayout* layout = nullptr;
};

/// How a layout covers its pages.
struct UvFigures {
  std::size_t islands = 0;           ///< faces that continue each other across edges, with one orientation
  std::size_t mirrored_islands = 0;  ///< show their faces from behind, as in a mirror
  std::size_t faces_without = 0;     ///< no texture coordinates
  std::size_t flat_faces = 0;        ///< whose texture coordinates have no area
  std::size_t overlapping_texels = 0,
              overlapping_faces = 0;  ///< whose middle lies in several faces; that share such texels
};

/// \pre the layout has an entry per face of the mesh, whose pages and texture coordinates exist. O(faces + texels), TBB.
UvFigures measure_uv(const Mesh& mesh, const labeling::FaceGraph& graph, const io::UvLayout& layout);

/// Throws std::invalid_argument unless the layout has an entry per face, with pages and texture coordinates that exist, finite and
/// in 0 .. 1, and pages of 1 to 32768 texels an edge. O(faces).
void check_layout(const Mesh& mesh, const io::UvLayout& layout);

/// The size of the atlas, known before any photo is read.
struct AtlasEstimate {
  std::size_t charts = 0, pages = 0;
  std::size_t page_texels = 0;  ///< of all pages after cropping; exact
  double reduction = 1;         ///< factor on the scale of all charts that meets the limits
};

/// Charts and their places on pages. Copies share them.
class AtlasPlan {
 public:
  struct State;
  explicit AtlasPlan(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  AtlasEstimate estimate() const;
  const State& state() const { return *state_; }

 private:
  std::shared_ptr<const State> state_;
};

/// A chart holds faces of one view that are connected, or so close in its photo that their paddings would overlap. Its
/// texture coordinates are the exact projections into that view's undistorted frame, so photo pixels are copied at full
/// resolution. A face that is so large that perspective bends it by half a pixel has a chart of its own. Faces tagged
/// partial take each texel from the best view whose coverage shows it. Reads no photo. Throws std::invalid_argument if
/// options and input do not fit together, or if even the smallest charts exceed a limit.
AtlasPlan plan_atlas(const AtlasInput& input, const AtlasOptions& options);

/// Exposure per view from the ratios across the seams of all faces, and from overlaps, for AtlasInput::exposure. In each channel the
/// geometric mean of the gains over all faces is one, so that the texture as a whole keeps its brightness. Over a long flight
/// photos keep theirs: ratios tell gains of photos a few seams apart from each other, but a small error of each would add up. Fetches the coarse
/// colours of each photo at most once.
std::vector<ViewExposure> fit_exposure(const AtlasInput& input);

/// The ratio of the colours that two views show, on the two sides of a seam edge or of one face, for a fit over the parts of a mesh.
struct ColorRatio {
  std::array<std::uint32_t, 2> views{};         ///< index(ViewId)
  std::array<std::array<double, 3>, 2> logs{};  ///< of the mean colour on each side, per channel
  std::array<std::array<double, 2>, 2> at{};    ///< x and y of its middle in each frame, px
  double weight = 0;
};
GPVC_MEMBERS(ColorRatio, views, logs, at, weight)

/// The ratios across seams whose lower-numbered face is not in the border, and those between all views of some faces that are not
/// (leveling/overlap_ratios.h): parts of a mesh that have each other's faces in their borders then give each once. Fetches the coarse
/// colours of each photo at most once.
std::vector<ColorRatio> color_ratios(const AtlasInput& input);

/// As above, from the ratios of all parts in any order that is the same each time. `faces`: per view, how many faces have it.
std::vector<ViewExposure> fit_exposure(const Scene& scene, std::vector<ColorRatio> ratios,
                                       std::span<const std::size_t> faces);

/// Compares each photo, at places all over what it textures, with three others that show them best, and with the photos beyond its
/// cuts. Faces of the border are no such places. Fetches the coarse colours of each photo at most once, or a few times where there are very many places. TBB.
std::vector<PhotoMatch> match_photos(const AtlasInput& input);

/// Bytes that a page takes for each of its texels while it is under construction: colour and state (4), and a third of that more
/// while it is finished, for coarser copies of it. While it is painted that third is free.
inline constexpr double kPageBytesPerTexel = 16.0 / 3, kFinishedPart = 0.25;
/// Likewise with samples of so many bytes a texel beside the colour: see BandSet::pixel_bytes().
constexpr double page_bytes_per_texel(std::size_t sample_bytes) {
  return kPageBytesPerTexel + static_cast<double>(sample_bytes);
}
/// What pages of a given layout take beside that: which chart each texel belongs to.
inline constexpr double kOwnerBytesPerTexel = 4;

/// Photos that bake_atlas() holds at a time, beside those that the photo source keeps: one in use, and one for each of up to
/// eight threads.
std::size_t photos_held();

/// Where corrections of seams and painted pages are kept for another run, and taken from.
struct KeptPages {
  io::WorkStore* store = nullptr;  ///< null: nothing is kept
  io::WorkKey key;  ///< of the program, the input and the options of the plan, except how unseen faces are textured
};

/// Memory and pages of a run of bake_atlas(). Its result is the same for any values.
struct BakeOptions {
  /// Begins work that needs texture coordinates but no pages; called before photos are read. The model stays where it is
  /// until that work is done: bake_atlas waits for it.
  std::function<std::future<void>(const io::TexturedModel& model)> take_model = {};
  /// Takes each page with its number as soon as it is finished; called by several threads at a time. Empty: the pages are
  /// returned.
  std::function<void(std::size_t number, Image page)> take_page = {};
  /// Likewise the samples of pages, where photos have bands, before take_page takes the page.
  std::function<void(std::size_t number, PageSamples page)> take_samples = {};
  /// Pages are baked in groups of at most so many bytes, one page at least.
  std::size_t page_bytes = std::numeric_limits<std::size_t>::max();
  /// Charts of partial faces are baked in batches of at most so many bytes, one chart at least, and each batch fetches its
  /// photos again. Charts are blended in such batches, too, which fetch coarse colours. Pages take 4 bytes a texel meanwhile.
  std::size_t batch_bytes = std::numeric_limits<std::size_t>::max();
  /// Where pages are spilled, to a file without a name of at most 4 bytes a texel, while partial and unseen faces on them wait for
  /// the colours of later groups. Empty: such pages stay in memory.
  std::filesystem::path scratch_folder = {};
  /// Pages are kept as the photos painted them, before anything is filled in: 4 bytes a texel.
  KeptPages kept = {};
};

/// Aligns photos, levels seams and bakes pages. To align photos their coarse colours are fetched, see match_photos(), and for
/// seams once more; for each group of pages, and
/// each of its batches, the photos that are shown there once, and the coarse colours of those that are blended there once.
/// `input` is what the plan was made from. Throws what the photo source throws, and OutputError where pages cannot be spilled.
/// Progress counts a hundred steps for each group of pages. It is called from any thread, but by one thread at a time, and also
/// while a photo is in use, so that an exception from it stops the work within a fraction of a second.
TextureAtlas bake_atlas(const AtlasPlan& plan, const AtlasInput& input, const Progress& progress,
                        const BakeOptions& options = {});

/// The photos from which a point of the texture takes its colour.
struct PointOrigin {
  ViewId first = kNoView;  ///< kNoView: no photo; the colour is continued from the surroundings, or painted
  PixelPoint first_at;     ///< in the view's undistorted frame
  /// A second view is blended in close to texels of that view; kNoView: none.
  ViewId second = kNoView;
  PixelPoint second_at;
  double second_share = 0;
};

/// From which photos bake_atlas takes each point of the texture, for accuracy measurements. Reads no photo.
class TextureOrigins {
 public:
  /// Borrows both. `input` is what the plan was made from. O(texels of partial faces x candidates), TBB; keeps some
  /// bytes for each of these texels.
  TextureOrigins(const AtlasPlan& plan, const AtlasInput& input);
  /// The origin of the point A + b (B - A) + c (C - A) of a face; no photo for faces of the border.
  PointOrigin at(FaceId face, double b, double c) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

/// plan_atlas and bake_atlas in one.
TextureAtlas build_atlas(const AtlasInput& input, const AtlasOptions& options, const Progress& progress);

}  // namespace gpvc::atlas
