// Chooses one view for each face: data costs from one pass over each view's IVM, Potts smoothness on the face adjacency
// graph, alpha expansion (Boykov, Veksler, Zabih 2001) with the maximum flow of Boykov and Kolmogorov (2004).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "../io/image.h"
#include "../io/names.h"
#include "../io/progress.h"
#include "../io/scene.h"
#include "../visibility/result.h"

namespace gpvc::labeling {

// --- adjacency

/// Around an edge of many faces, each is paired with this many of the next ones in face order. Up to four faces, as where two
/// buildings meet or both sides of a wall are faces, are all paired; around more, the number of pairs stays linear.
inline constexpr std::size_t kFaceGraphReach = 3;

/// Pairs of faces that share an edge (two vertex indices) and are within kFaceGraphReach around it, each pair once, lower
/// face first, in ascending order.
struct FaceGraph {
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<float> weights = {};  ///< per pair, >= 0; empty: all 1
};

/// O(faces log faces), TBB inside. The result does not depend on the number of threads. Throws InputError for a mesh that
/// validate_faces() refuses.
FaceGraph face_graph(const Mesh& mesh);

/// What a seam between two faces costs.
/// - uniform: the same everywhere (Potts).
/// - length: in proportion to the shared edge's length. The mean is 1, so that the tessellation does not matter; the
///   maximum is 4, so that a few long edges do not decide everything.
/// - dihedral: less across a fold, where seams are hard to see: (1 + cos) / 2 of the angle between the normals, at least
///   0.05.
/// - length_dihedral: the product of both.
enum class EdgeWeights { uniform, length, dihedral, length_dihedral };
inline constexpr Named<EdgeWeights> kEdgeWeightsNames[] = {{"uniform", EdgeWeights::uniform},
                                                           {"length", EdgeWeights::length},
                                                           {"dihedral", EdgeWeights::dihedral},
                                                           {"both", EdgeWeights::length_dihedral}};

/// Fills graph.weights. O(pairs), TBB inside.
void weigh_edges(const Mesh& mesh, EdgeWeights weights, FaceGraph& graph);

// --- data costs

/// Candidate views of every face with their costs, compressed by face; views ascend within a face.
struct CostTable {
  std::vector<std::size_t> first;    ///< faces + 1 offsets into views and costs
  std::vector<std::uint32_t> views;  ///< index(ViewId)
  std::vector<float> costs;          ///< finite, >= 0; 0 is best
  std::size_t faces() const { return first.empty() ? 0 : first.size() - 1; }
  std::span<const std::uint32_t> views_of(std::size_t face) const {
    return {views.data() + first[face], first[face + 1] - first[face]};
  }
  std::span<const float> costs_of(std::size_t face) const {
    return {costs.data() + first[face], first[face + 1] - first[face]};
  }
};

/// What makes a view good for a face: its projected area, the photo's gradient magnitude integrated over that area, or
/// either of them times the squared cosine of the viewing angle. The first cosine accounts for resolution: a slanted
/// surface has fewer pixels in one direction, and area times cosine is the square of their density in that one. The second stands
/// for what else gets worse at grazing angles: parallax, reflections and errors of the mesh grow with 1 / cosine.
/// nadir: for pictures of the ground from above. The photo that looks straight down (against z) at a place is the best for it,
/// whatever the face's normal, which tells little in a mesh made from heights: the fourth power of the cosine between the line of
/// sight and the vertical, times the square of that between the camera's axis and the vertical, as in mvs-texturing's nadir mode.
enum class DataTerm { area, area_angle, gmi, gmi_angle, nadir };
inline constexpr Named<DataTerm> kDataTermNames[] = {{"area", DataTerm::area},
                                                     {"area-angle", DataTerm::area_angle},
                                                     {"gmi", DataTerm::gmi},
                                                     {"gmi-angle", DataTerm::gmi_angle},
                                                     {"nadir", DataTerm::nadir}};

/// What becomes of a view whose colour disagrees with the face's other views: nothing, a lower quality, or rejection.
enum class Outliers { none, damp, clamp };
inline constexpr Named<Outliers> kOutliersNames[] = {
    {"none", Outliers::none}, {"damp", Outliers::damp}, {"clamp", Outliers::clamp}};

/// Whether what photos show beside the object is kept off it (background.h).
enum class Background { none, automatic };
inline constexpr Named<Background> kBackgroundNames[] = {{"auto", Background::automatic}, {"none", Background::none}};

struct CostOptions {
  DataTerm term = DataTerm::area_angle;
  Outliers outliers = Outliers::clamp;
  Background background = Background::automatic;
  /// Cost of a view of quality 0; one with half the quality of the face's best view costs half of it. The unit is the cost of a
  /// seam between two neighbouring faces (the solver's smoothness). A lower weight gives larger patches. Chosen by the error on
  /// held-out photos.
  double data_weight = 0.05;
  /// Width of the strip along depth discontinuities of the IVM in which candidates cost more, because photos and mesh
  /// disagree there by a few pixels; 0 = no strip.
  int margin_px = 5;
  /// Added to the cost of a face that lies in the strip entirely, in proportion otherwise. The default outweighs the
  /// three neighbours that a face can disagree with, so that even a single face prefers a view outside the strip.
  double margin_cost = 3.0;
  /// Added per halving of a view's quality against the face's best candidate. The first two halvings are free, because
  /// larger patches are worth that loss; at most two more are counted.
  double coarse_cost = 0.5;
  /// Uses views that agree with the others no better than by chance. Where most views are like that they are used anyway,
  /// since then nothing tells which are right: see Candidates::agreement.
  bool keep_odd_views = false;
  /// Added to the cost of a partial view, times the share of the face that it does not see.
  double hidden_cost = 1.0;
};

/// How a face's candidates see it: in full, only in part, or there are none; then photos may show background in its place
/// (labeling/background.h). The values are those of tags.npy.
enum class FaceTag : std::uint8_t { seen = 0, partial = 1, unseen = 2, background = 3 };
constexpr bool has_candidates(FaceTag tag) { return tag == FaceTag::seen || tag == FaceTag::partial; }

/// How well a photo agrees with the others about the surfaces that they see.
struct ViewAgreement {
  ViewId view{};
  std::size_t steps = 0;   ///< places that were compared
  double correlation = 0;  ///< with the mean of the other photos there, -1..1
  double chance = 0;       ///< root mean square of the correlations with other places
  bool judged = false;     ///< there are enough places
  /// Judged, and agrees no better than chance, or with less than a quarter of the views' median: the photo or the pose is
  /// another's, or the photo is turned.
  bool by_chance = false;
};

/// True if more than half of the judged views agree by chance.
bool mostly_by_chance(std::span<const ViewAgreement> agreement);

struct Candidates {
  CostTable table;
  std::vector<FaceTag> tags;                        ///< per face
  std::size_t full = 0, partial = 0, rejected = 0;  ///< number of candidates kept, and of views rejected as outliers
  std::vector<ViewAgreement> agreement;             ///< of all views, ascending
  /// Per view: of the faces that it and at least two others see whole, the share on which its colour differs from theirs.
  std::vector<double> outlier_share;
  std::vector<FaceId> refused;  ///< faces that views see, none of which is allowed; ascending
};

inline constexpr double kMostLog2Gain = 8;

/// What comparing all photos tells of each, for faces that are judged in parts.
struct PhotoJudgement {
  std::vector<ViewAgreement> agreement;  ///< of all views with statistics, ascending
  /// Per view and channel, the logarithm to base 2 of the factor that its colours are divided by to agree with the others', at
  /// most kMostLog2Gain, of either sign.
  std::vector<double> log2_gain;
};

/// Bytes that comparing photos takes beside their statistics, at most: where they differ everywhere. `records`: faces that views see
/// whole, each view's by itself, which show them with `pixels` in all.
double judging_bytes(double records, double pixels, double faces);

/// True if the bytes may be the statistics of a view: faces that are there, ascending. \param faces of the mesh
bool is_sound(std::span<const std::byte> statistics, std::size_t faces);

/// Collects statistics (pixel area, gradient magnitude, mean colour) of the faces that each view sees, then derives
/// candidates and costs from them.
class CandidateCollector {
 public:
  /// `wanted`: a flag per face, or empty for all. Faces that are not wanted occlude and get no candidates (FaceTag::unseen).
  /// Wanted faces get the statistics that they have in a run on all faces. Their candidates and costs are equal to that
  /// run's as well if `outliers` is none: outliers are found by comparing photos over all
  /// collected faces, so wanted faces need a border of some ten more faces around them to come close.
  CandidateCollector(const Mesh& mesh, const CostOptions& options, std::vector<std::uint8_t> wanted = {});
  ~CandidateCollector();
  /// Each view once, in any order; the result does not depend on the order. O(faces + pixels), TBB inside.
  void add_view(ViewId id, const View& view, const Image& photo, const visibility::ViewVisibility& visibility);
  /// The statistics of a view, for add_statistics() of a collector of the same mesh and options. Empty for a view that judge() left out.
  std::vector<std::byte> statistics_of(ViewId id) const;
  /// Forgets a view, whose statistics have been taken elsewhere.
  void forget(ViewId id);
  /// Takes them instead of add_view(). False, and the view is not added, unless they are sound.
  bool add_statistics(ViewId id, std::span<const std::byte> statistics);
  /// Per view the photo that it shows, where several show one, as the views of a panorama do: such views have one vote about
  /// the colours of a face. Each view shows its own where this is not called. To be called before judge().
  void set_photos(std::vector<std::uint32_t> photo_of_view);
  /// After the last view: compares the photos with each other, leaves out those that agree by chance, and notes in the
  /// statistics how far each photo disagrees with the others about each face. `graph`: the mesh's face_graph(), which is made
  /// here if it is null.
  void judge(const FaceGraph* graph = nullptr);
  /// Bytes that judge() takes at most, and the statistics that have been added. O(records).
  double judging_bytes() const;
  /// judge() for a scene in parts, in two steps. The first is called on a collector of some faces from all over the scene (a
  /// million suffice), the second on each part, with what the first returned.
  PhotoJudgement judge_photos(const FaceGraph* graph = nullptr);
  void judge_faces(const PhotoJudgement& photos, const FaceGraph* graph = nullptr);
  /// Instead of judge(), where all statistics come from a collector that had judged them. `agreement`: what it found.
  void take_judgement(std::vector<ViewAgreement> agreement);
  const std::vector<ViewAgreement>& agreement() const;

  /// True for the views that may texture a face; empty: all.
  using Allowed = std::function<bool(FaceId, ViewId)>;
  /// The candidates of a face are its full views. They are its partial views, at a cost that grows with the hidden share,
  /// where it has no full view, where all full views are outliers, or where all of them have the face within the strip
  /// along silhouettes and some partial view has less than half of it there. What views see of faces that `allowed` refuses
  /// them counts as unseen; it has been compared with the other photos before. \pre judge() or take_judgement().
  /// O(faces + records), TBB.
  Candidates candidates(const Allowed& allowed = {}) const;
  /// judge(), unless that is done, and candidates(), with less memory: nothing may be called afterwards.
  Candidates finish(const FaceGraph* graph = nullptr, const Allowed& allowed = {});

 private:
  struct State;
  void leave_out(std::span<const ViewAgreement> agreement);
  std::unique_ptr<State> state_;
};

/// Reads a cost table: a folder with counts.npy (uint32, number of candidates per face), views.npy (uint32) and
/// costs.npy (float32), both face after face as in CostTable, or mvs-texturing's sparse table (`SPT 0.2 FACES VIEWS
/// ENTRIES\n`, then records of uint32 face, uint16 view, float32 cost, little-endian, in any order). Throws InputError.
/// O(entries).
CostTable read_costs(const std::filesystem::path& path);

/// Writes the folder that read_costs reads; makes it if it is missing. Throws OutputError.
void write_costs(const std::filesystem::path& folder, const CostTable& table);

// --- selection

struct SolverOptions {
  double smoothness = 1.0;  ///< cost of two neighbouring faces with different views, times the pair's weight
  int max_sweeps = 30;      ///< over all labels, of the full problem; stops earlier when nothing changes
  /// Also expands every label over all its faces, until no expansion of any label lowers the energy. Otherwise only faces
  /// near borders between labels, or with a much cheaper candidate, change the labels that a coarser problem gave them:
  /// several times as fast, for an energy up to 0.2 % higher on scenes from photos.
  bool thorough = false;
  /// A patch of at most so many faces takes a neighbouring patch's view if that raises the energy by no more than
  /// small_patch_rise.
  int small_patch_faces = 4;
  double small_patch_rise = 0.0;
};

struct SweepReport {
  int sweep = 0;
  double energy = 0;
  double seconds = 0;  ///< since the start of the selection
};

struct Selection {
  std::vector<ViewId> labels;      ///< per face; kNoView where the table has no candidate
  std::size_t merged_patches = 0;  ///< small patches merged after the last sweep
  double energy = 0;               ///< labeling_energy of the labels
  std::size_t differing_pairs = 0;
  std::size_t patches = 0;  ///< connected components of equal label
  std::vector<SweepReport> sweeps;
};

/// Minimizes the energy by alpha expansion. The result does not depend on the number of threads; the energy never rises
/// from sweep to sweep.
///
/// `fixed`: empty, or a view per face that the face must keep, kNoView where the solver chooses. With it a part of a mesh
/// is solved inside labels that are given around it. A fixed face needs no candidates: the pairs with its neighbours
/// count, its own cost is taken from the table where the table has it. labels[face] == fixed[face] wherever that is a
/// view. With `thorough`, and always below some 2000 faces, the other faces get the labels of a fixpoint: no expansion of any
/// label over them lowers the energy, given the fixed ones (unless max_sweeps ends the search). Throws
/// std::invalid_argument if `fixed` or `start` is of another size.
///
/// `start`: empty, or labels to begin with, which are then improved along their borders, instead of those of a coarser
/// problem. A face that does not have its label as a candidate begins with its cheapest one.
Selection select_views(const CostTable& table, const FaceGraph& graph, const SolverOptions& options,
                       const Progress& progress, std::span<const ViewId> fixed = {},
                       std::span<const ViewId> start = {});

struct Reselection {
  Selection selection;
  std::size_t free_faces = 0;  ///< that could get another label
};

/// Labels for a table that differs from an earlier one at the faces `changed` alone. `before`: those chosen for that. Faces
/// more than kReselectEdges edges away from changed ones keep their labels. Changed faces are labeled first, between the
/// others' labels; from there all free faces are improved, so that they change their labels only where that lowers the
/// energy. O(faces + candidates), and select_views() over the free faces.
Reselection reselect_views(const CostTable& table, const FaceGraph& graph, const SolverOptions& options,
                           const Progress& progress, std::span<const ViewId> before, std::span<const FaceId> changed);
/// As far as a label grows in a move of the solver.
inline constexpr int kReselectEdges = 16;

/// Sum of the costs of the given labels and of smoothness * weight over the pairs whose labels differ (pairs with a face
/// without a view do not count). A label that is no candidate of its face costs nothing.
double labeling_energy(const CostTable& table, const FaceGraph& graph, std::span<const ViewId> labels,
                       double smoothness);

}  // namespace gpvc::labeling
