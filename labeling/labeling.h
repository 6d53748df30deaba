// One view per face: data costs from one pass over each view's IVM, Potts smoothness on the face adjacency graph, alpha
// expansion (Boykov, Veksler, Zabih 2001) with max-flow by Boykov and Kolmogorov (2004) from Boost.Graph.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "../io/io.h"
#include "../io/names.h"
#include "../io/scene.h"
#include "../visibility/visibility.h"

namespace gpvc::labeling {

// --- adjacency

/// Pairs of faces that share an edge (two vertex indices), each pair once, lower face first, in ascending order. An
/// edge with k > 2 faces (non-manifold) joins each consecutive pair in face order, so degree stays linear.
struct FaceGraph {
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<float> weights = {};  ///< per pair, >= 0; empty: all 1
};

/// O(faces log faces), deterministic for any number of threads.
FaceGraph face_graph(const Mesh& mesh);

/// What a seam between two faces costs: the same everywhere (Potts), in proportion to the shared edge's length (mean 1,
/// so that tessellation does not matter; at most 4, so that one long edge does not rule), less across a fold ((1 + cos)
/// / 2 of the angle between the normals, at least 0.05, where seams hide), or length and fold.
enum class EdgeWeights { uniform, length, dihedral, length_dihedral };
inline constexpr Named<EdgeWeights> kEdgeWeightsNames[] = {{"uniform", EdgeWeights::uniform},
                                                           {"length", EdgeWeights::length},
                                                           {"dihedral", EdgeWeights::dihedral},
                                                           {"both", EdgeWeights::length_dihedral}};

/// Fills graph.weights. O(pairs), TBB.
void weigh_edges(const Mesh& mesh, EdgeWeights weights, FaceGraph& graph);

// --- data costs

/// Candidate views of every face with their costs, compressed by face; views ascend within a face. Never dense.
struct CostTable {
  std::vector<std::size_t> first;    ///< faces + 1 offsets into views and costs
  std::vector<std::uint32_t> views;  ///< index(ViewId)
  std::vector<float> costs;          ///< >= 0, finite; 0 best
  std::size_t faces() const { return first.empty() ? 0 : first.size() - 1; }
};

/// What makes a view good for a face: its projected area, the photo's gradient magnitude integrated over that area, or
/// the integral weighted by the viewing angle.
enum class DataTerm { area, gmi, gmi_angle };
inline constexpr Named<DataTerm> kDataTermNames[] = {
    {"area", DataTerm::area}, {"gmi", DataTerm::gmi}, {"gmi-angle", DataTerm::gmi_angle}};

/// What becomes of a view whose colour disagrees with the face's other views: nothing, a lower quality, or rejection.
enum class Outliers { none, damp, clamp };
inline constexpr Named<Outliers> kOutliersNames[] = {
    {"none", Outliers::none}, {"damp", Outliers::damp}, {"clamp", Outliers::clamp}};

struct CostOptions {
  DataTerm term = DataTerm::area;
  Outliers outliers = Outliers::clamp;
  /// Cost of the data term's worst against its best, where a pair of differing neighbours costs 1 (the solver's
  /// smoothness): less means larger patches. Chosen by held-out error.
  double data_weight = 0.25;
  /// Width of the strip along depth discontinuities of the IVM in which candidates cost more (photos and mesh disagree
  /// there by a few pixels); 0 = off.
  int margin_px = 5;
  /// Added to the cost of a face that lies in that strip as a whole, in proportion otherwise. The default outweighs the
  /// three neighbours that a face can disagree with, so that a clean view wins even for a single face.
  double margin_cost = 3.0;
  /// Added per halving of a view's quality against the face's best candidate, beyond the first two, at most twice: a
  /// grazing view smears, and in the data term alone, which compares with the best faces of the whole scene, a small
  /// face's views hardly differ. Two halvings are free because patches are worth that much.
  double coarse_cost = 0.5;
  /// Added to the cost of a partial view, times the share of the face that it does not see.
  double hidden_cost = 1.0;
};

/// By how much of a face its best view shows: some view sees it in full, only partial views see it, none does. The
/// values are those of tags.npy.
enum class FaceTag : std::uint8_t { seen = 0, partial = 1, unseen = 2 };

struct Candidates {
  CostTable table;
  std::vector<FaceTag> tags;                        ///< per face: has a full candidate / only partial ones / none
  std::size_t full = 0, partial = 0, rejected = 0;  ///< candidates kept, and dropped as outliers
};

/// Collects per-view statistics (pixel area, gradient magnitude, mean colour) for the faces a view sees, sparse.
class CandidateCollector {
 public:
  CandidateCollector(const Mesh& mesh, const CostOptions& options);
  ~CandidateCollector();
  CandidateCollector(const CandidateCollector&) = delete;
  CandidateCollector& operator=(const CandidateCollector&) = delete;
  /// O(faces + pixels), TBB inside. Views may come in any order; the result does not depend on it.
  void add_view(ViewId id, const View& view, const Image& photo, const visibility::ViewVisibility& visibility);
  /// A face with a full candidate takes only those, unless outliers reject them all; a face without takes its partial
  /// views, at a cost that grows with the hidden share.
  Candidates finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Reads a cost table: a folder with counts.npy (uint32, candidates of each face), views.npy (uint32) and costs.npy
/// (float32), both face after face as in CostTable, or mvs-texturing's sparse table (`SPT 0.2 FACES VIEWS ENTRIES\n`,
/// then records of uint32 face, uint16 view, float32 cost, little-endian, in any order). Throws InputError. O(entries).
CostTable read_costs(const std::filesystem::path& path);

/// Writes the folder that read_costs reads (made when missing). Throws OutputError.
void write_costs(const std::filesystem::path& folder, const CostTable& table);

// --- selection

struct SolverOptions {
  double smoothness = 1.0;  ///< Potts penalty of a pair with different views
  int max_sweeps = 30;      ///< over all labels, most of them over few faces; stops earlier at the fixpoint
  /// Patches of at most this many faces are merged into a neighbour's where that raises the energy by no more than
  /// small_patch_rise each.
  int small_patch_faces = 4;
  double small_patch_rise = 0.0;
};

struct SweepReport {
  int sweep = 0;
  double energy = 0;
  double seconds = 0;
};

struct Selection {
  std::vector<ViewId> labels;      ///< per face; kNoView where the table has no candidate
  std::size_t merged_patches = 0;  ///< small ones, after the last sweep
  double energy = 0;  ///< sum of chosen costs + smoothness * weights of differing pairs (both with candidates)
  std::size_t differing_pairs = 0;
  std::size_t patches = 0;  ///< connected components of equal label
  std::vector<SweepReport> sweeps;
};

/// Minimizes the energy by alpha expansion. Deterministic for any number of threads; energy never rises.
Selection select_views(const CostTable& table, const FaceGraph& graph, const SolverOptions& options,
                       const Progress& progress);

/// Energy, differing pairs and patches of given labels (for tests, comparisons and `gpvc label`).
double labeling_energy(const CostTable& table, const FaceGraph& graph, std::span<const ViewId> labels,
                       double smoothness);

}  // namespace gpvc::labeling
