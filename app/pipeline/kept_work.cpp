#include "app/pipeline/kept_work.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <string>
#include <utility>
#include <variant>

#include "io/lens_terms.h"
#include "io/tie_points.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

void add(io::WorkHash& hash, const WorldPoint& p) {
  for (const double value : {p.x, p.y, p.z}) hash.add(value);
}

void add(io::WorkHash& hash, const View& view) {
  for (const double value : view.pose.rotation) hash.add(value);
  add(hash, view.pose.centre);
  const Camera& camera = view.camera;
  for (const int value : {camera.width, camera.height}) hash.add(value);
  for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy, camera.distortion.max_r2}) hash.add(value);
  hash.add(camera.distortion.model);
  for (const LensTerm& term : kLensTerms) hash.add(camera.distortion.*term.term);
  const Motion& motion = camera.distortion.motion;
  for (const double value : {motion.across, motion.down}) hash.add(value);
  for (const auto* vector : {&motion.turn, &motion.step, &motion.nearness})
    for (const double value : *vector) hash.add(value);
  for (const double value : camera.distortion.lens_from_frame) hash.add(value);
  hash.add(camera.distortion.max_angle);
}

void add(io::WorkHash& hash, const visibility::VisibilityOptions& options, int device) {
  hash.add(options.method.index());
  hash.add_text(visibility::visibility_mode_name(options.method));
  if (const auto* gpvc = std::get_if<visibility::Gpvc>(&options.method)) {
    hash.add(gpvc->drawing);
    hash.add(gpvc->classifier);
  } else if (const auto* paper = std::get_if<visibility::PaperGpvc>(&options.method)) {
    hash.add(paper->projection);
    hash.add(paper->correction);
    hash.add(paper->classifier);
  } else if (const auto* rays = std::get_if<visibility::RayTracing>(&options.method)) {
    hash.add(rays->drawing);
  } else if (const auto* none = std::get_if<visibility::NoTest>(&options.method)) {
    hash.add(none->drawing);
  }
  hash.add(options.subpixel);
  hash.add(device);
}

// What the records of a view depend on.
void add_records(io::WorkHash& hash, const labeling::CostOptions& options) {
  hash.add(options.term);
  hash.add(options.margin_px);
}

void add(io::WorkHash& hash, const ViewRule& rule) {
  hash.add(rule.region.index());
  if (const auto* box = std::get_if<io::BoxRegion>(&rule.region)) {
    add(hash, box->low);
    add(hash, box->high);
  } else if (const auto* ground = std::get_if<io::GroundRegion>(&rule.region)) {
    hash.add_all(std::span<const std::array<double, 2>>(ground->corners));
    hash.add(ground->low);
    hash.add(ground->high);
  } else {
    hash.add_all(std::span<const std::array<std::uint32_t, 2>>(std::get<io::FaceRegion>(rule.region).ranges));
  }
  hash.add(rule.allow);
  hash.add_all(std::span<const ViewId>(rule.views));
}

// What candidates and labels depend on besides, except rules about views.
void add_choice(io::WorkHash& hash, const Settings& settings) {
  const labeling::CostOptions& costs = settings.costs;
  hash.add(costs.outliers);
  for (const double value : {costs.data_weight, costs.margin_cost, costs.coarse_cost, costs.hidden_cost})
    hash.add(value);
  hash.add(costs.keep_views);
  hash.add(settings.edge_weights);
  const labeling::SolverOptions& solver = settings.solver;
  hash.add(solver.smoothness);
  hash.add(solver.max_sweeps);
  hash.add(solver.thorough);
  hash.add(solver.small_patch_faces);
  hash.add(solver.small_patch_rise);
}

void add(io::WorkHash& hash, const atlas::AtlasOptions& options) {
  hash.add(options.page_size);
  hash.add(options.padding);
  hash.add(options.seams);
  hash.add(options.blend);
  hash.add(options.blend_cost);
  hash.add(options.margin_px);
  hash.add(options.texel_size);
  hash.add(options.max_pages);
  hash.add(options.max_texels);
  // Faces without a view are filled after a page is kept.
}

void add(io::WorkHash& hash, const Mesh& mesh) {
  hash.add_all(std::span<const WorldPoint>(mesh.positions));
  hash.add_all(std::span<const Triangle>(mesh.faces));
}

// The keys of the views' photos; nullopt for those of unknown bytes.
std::vector<std::optional<io::WorkKey>> photo_keys(const Input& input, io::PhotoSource& photos, Observer& observer) {
  std::vector<std::optional<io::WorkKey>> keys(input.views.size());
  tbb::parallel_for(std::size_t{0}, keys.size(), [&](std::size_t n) {
    observer.check_cancelled();
    keys[n] = photos.key(input.views[n]);
  });
  return keys;
}

// Of what all parts come from. nullopt if this program cannot be read.
std::optional<io::WorkKey> common_key(const Input& input, const Settings& settings) {
  io::WorkHash hash;
  try {
    hash.add_file("/proc/self/exe");
  } catch (const InputError&) {
    return std::nullopt;
  }
  if (const auto tie_points = io::tie_points_file(input.scene)) hash.add_file(*tie_points);
  add(hash, input.mesh);
  add(hash, settings.visibility, settings.device);
  add_records(hash, settings.costs);
  return hash.key();
}

std::string view_name(ViewId id) { return fmt::format("view-{}", index(id)); }

}  // namespace

KeptWork::KeptWork(io::WorkStore store, std::vector<std::pair<ViewId, io::WorkKey>> views, io::WorkKey selection,
                   io::WorkKey atlas)
    : store_(std::move(store)), views_(views.begin(), views.end()), selection_(selection), atlas_(atlas) {}

std::optional<KeptWork> KeptWork::make(const fs::path& folder, const Input& input, const Settings& settings,
                                       io::PhotoSource& photos, Observer& observer) {
  const std::optional<io::WorkKey> common = common_key(input, settings);
  if (!common) return std::nullopt;
  std::vector<std::pair<ViewId, io::WorkKey>> views;
  for (std::size_t n = 0; const std::optional<io::WorkKey>& photo : photo_keys(input, photos, observer)) {
    if (!photo) return std::nullopt;
    const ViewId id = input.views[n++];
    io::WorkHash hash;
    hash.add(common->bits);
    hash.add(photo->bits);
    add(hash, input.scene.views[index(id)]);
    views.emplace_back(id, hash.key());
  }
  io::WorkHash hash;
  for (const auto& [id, key] : views) {
    hash.add(id);
    hash.add(key.bits);
  }
  add_choice(hash, settings);
  hash.add(settings.view_rules.size());
  for (const ViewRule& rule : settings.view_rules) add(hash, rule);
  const io::WorkKey selection = hash.key();
  add(hash, settings.atlas);
  return KeptWork(io::WorkStore(folder), std::move(views), selection, hash.key());
}

std::optional<ViewWork> KeptWork::view(ViewId id) {
  ViewWork work;
  const bool found = store_.read(view_name(id), views_.at(id), [&](io::WorkStore::Reader& in) {
    work.statistics = in.get_all<std::byte>();
    work.coverage = {id, in.get_all<std::uint8_t>()};
    work.visibility = in.get<visibility::VisibilityStatistics>();
    work.tie_points = in.get<checks::FitGroups>();
  });
  if (!found) return std::nullopt;
  // Seconds are those of this run.
  visibility::VisibilityStatistics& s = work.visibility;
  for (double* seconds : {&s.render_s, &s.build_s, &s.upload_s, &s.readback_s, &s.classify_s, &s.shader_s, &s.claims_s})
    *seconds = 0;
  ++views_taken_;
  return work;
}

void KeptWork::keep_view(ViewId id, std::span<const std::byte> statistics, const PackedCoverage& coverage,
                         const visibility::VisibilityStatistics& visibility, const checks::FitGroups& tie_points) {
  store_.keep(view_name(id), views_.at(id), [&](io::WorkStore::Writer& out) {
    out.add_all(statistics);
    out.add_all(coverage.bytes);
    out.add(visibility);
    out.add(tie_points);
  });
}

std::optional<labeling::Selection> KeptWork::selection(std::size_t faces) const {
  labeling::Selection s;
  const bool found = store_.read("labels", selection_, [&](io::WorkStore::Reader& in) {
    s.labels = in.get_all<ViewId>();
    s.merged_patches = in.get<std::size_t>();
    s.energy = in.get<double>();
    s.differing_pairs = in.get<std::size_t>();
    s.patches = in.get<std::size_t>();
    s.sweeps = in.get_all<labeling::SweepReport>();
    if (s.labels.size() != faces) in.refuse();
  });
  return found ? std::optional(std::move(s)) : std::nullopt;
}

void KeptWork::keep_selection(const labeling::Selection& s) {
  store_.keep("labels", selection_, [&](io::WorkStore::Writer& out) {
    out.add_all(s.labels);
    out.add(s.merged_patches);
    out.add(s.energy);
    out.add(s.differing_pairs);
    out.add(s.patches);
    out.add_all(s.sweeps);
  });
}

ResultKeys result_keys(const Input& input, const Settings& settings, io::PhotoSource& photos, Observer& observer) {
  io::WorkHash mesh, views, options;
  add(mesh, input.mesh);
  for (std::size_t n = 0; const std::optional<io::WorkKey>& photo : photo_keys(input, photos, observer)) {
    const ViewId id = input.views[n++];
    views.add(id);
    views.add(photo.value_or(io::WorkKey{}).bits);
    add(views, input.scene.views[index(id)]);
  }
  add(options, settings.visibility, settings.device);
  add_records(options, settings.costs);
  add_choice(options, settings);
  add(options, settings.atlas);
  options.add(settings.atlas.unseen);
  options.add(settings.atlas.unseen_color);
  options.add(settings.output.texture);
  return {mesh.key(), views.key(), options.key()};
}

void KeptWork::warn_of_failure(Observer& observer) {
  const std::optional<std::string> failure = warned_ ? std::nullopt : store_.failure();
  if (!failure) return;
  warned_ = true;
  observer.warning(
      fmt::format("{}; no more work is kept, so a run that is cut off will repeat what follows", *failure));
}

double kept_bytes(const Workload& work) {
  // A record and the coverage of a partial face, of which there are few; a label a face; colour and state a texel, and the
  // corrections along seams.
  return 24 * work.pairs + 30 * work.faces + 4.5 * work.texels;
}

}  // namespace gpvc::pipeline
