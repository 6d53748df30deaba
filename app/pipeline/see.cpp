// What the views see: visibility, candidates and coverage, view after view.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <future>
#include <map>
#include <string>

#include "app/checks/hypotheses.h"
#include "app/checks/tie_point_fit.h"
#include "app/pipeline/coverage_store.h"
#include "app/pipeline/kept_work.h"
#include "app/pipeline/steps.h"
#include "io/clock.h"
#include "io/scene_files.h"
#include "visibility/visibility.h"

namespace gpvc::pipeline {
namespace {

// Leaves candidates to the given faces alone.
void keep_faces(std::span<const FaceId> faces, labeling::Candidates& candidates) {
  labeling::CostTable& table = candidates.table;
  std::vector<bool> kept(table.faces(), false);
  for (const FaceId face : faces) kept[index(face)] = true;
  labeling::CostTable rest;
  rest.first.push_back(0);
  for (std::size_t f = 0; f < kept.size(); ++f) {
    if (kept[f]) {
      for (std::size_t i = table.first[f]; i < table.first[f + 1]; ++i) {
        rest.views.push_back(table.views[i]);
        rest.costs.push_back(table.costs[i]);
      }
    } else {
      candidates.tags[f] = labeling::FaceTag::unseen;
    }
    rest.first.push_back(rest.views.size());
  }
  table = std::move(rest);
}

void report_times(const Seen& seen, Observer& observer) {
  const visibility::VisibilityStatistics& s = seen.statistics;
  for (const auto& [name, value] : {std::pair{"render_s", s.render_s},
                                    {"build_s", s.build_s},
                                    {"upload_s", s.upload_s},
                                    {"readback_s", s.readback_s},
                                    {"classify_s", s.classify_s},
                                    {"costs_s", seen.costs_s}})
    observer.stage_figure(name, value);
}

// A mesh that hardly any photo sees is one in other coordinates, as a rule. A part of the photos may show a part of it.
void report_unseen(const Input& input, bool allow, std::span<const labeling::FaceTag> tags,
                   std::span<const checks::SmallPhoto> photos, Observer& observer) {
  const auto [seen, partial, unseen] = count_tags(tags);
  if (static_cast<double>(seen + partial) >= kLeastSeen * static_cast<double>(tags.size())) return;
  const std::string found = fmt::format("photos see less than {:.0f} % of the faces", 100 * kLeastSeen);
  if (allow || 2 * input.views.size() < input.scene.views.size())
    return observer.warning(found + "; are mesh and cameras in the same coordinates?");
  const std::string explanation = fitting_hypothesis(input, photos, observer);
  throw InputError(input.mesh_file, "",
                   found +
                       (explanation.empty() ? "; are mesh and cameras in the same coordinates?" : ": " + explanation) +
                       "; --allow-unseen textures all the same");
}

// Wrong photos or poses must not become a texture without a word.
void report_agreement(const Input& input, bool keep, std::span<const labeling::ViewAgreement> agreement,
                      std::span<const checks::SmallPhoto> photos, Observer& observer) {
  std::vector<std::string> wrong;
  std::vector<double> correlations;
  for (const labeling::ViewAgreement& each : agreement) {
    if (each.judged) correlations.push_back(each.correlation);
    if (each.by_chance) wrong.push_back(input.scene.views[index(each.view)].name);
  }
  std::ranges::sort(correlations);
  observer.figure("agreement.judged", correlations.size());
  observer.figure("agreement.by_chance", wrong.size());
  observer.figure("agreement.median", correlations.empty() ? 0 : correlations[correlations.size() / 2]);
  for (const labeling::ViewAgreement& each : agreement)
    observer.detail(fmt::format("  {}: agrees with other photos by {:.3f} at {} places, chance gives {:.3f}",
                                input.scene.views[index(each.view)].name, each.correlation, each.steps, each.chance));
  if (wrong.empty()) return;
  const std::string found = fmt::format("{} of {} photos agree with the others no better than chance: {}", wrong.size(),
                                        correlations.size(), results::readable_list(wrong, 5));
  if (!labeling::mostly_by_chance(agreement))
    return observer.warning(found + "; do they belong to other poses, or are they turned?" +
                            (keep ? "" : " They are left out; --keep-views uses them"));
  if (keep) return observer.warning(found + "; mesh, poses and photos do not fit together");
  const std::string explanation = fitting_hypothesis(input, photos, observer);
  throw InputError(input.mesh_file, "",
                   found + "; mesh, poses and photos do not fit together: " +
                       (explanation.empty()
                            ? "photos of other poses or turned ones, inverse poses, another lens, or a mesh elsewhere"
                            : explanation) +
                       "; --keep-views textures all the same");
}

MeshFit fit_of(const Input& input, const labeling::Candidates& candidates, std::span<const checks::SmallPhoto> photos) {
  std::vector<ViewId> left_out;  // where --keep-views gives them candidates
  if (!labeling::mostly_by_chance(candidates.agreement))
    for (const labeling::ViewAgreement& each : candidates.agreement)
      if (each.by_chance) left_out.push_back(each.view);
  return measure_fit(input.mesh, input.scene, photos,
                     choose_places(input.mesh, input.scene, candidates.table, photos, left_out));
}

// A mesh elsewhere must not be textured without a word either.
void report_fits(const Input& input, bool keep, const Seen& seen, std::span<const checks::SmallPhoto> photos,
                 Observer& observer) {
  std::vector<std::string> doubts;
  using enum MeshFit::Verdict;
  bool elsewhere_for_one = false;
  const auto report = [&](const std::string& name, const MeshFit& fit, const std::string& text) {
    observer.figure(name + ".places", fit.places);
    observer.figure(name + ".found", fit.found);
    observer.figure(name + ".share", fit.share);
    observer.figure(name + ".error", fit.error);
    observer.detail("  " + text);
    elsewhere_for_one |= fit.verdict == elsewhere;
    if (fit.verdict == doubtful || fit.verdict == elsewhere) doubts.push_back(text);
  };
  // A view that agrees with another may do so by chance; most of them together do not. Tie points tell of mesh and poses,
  // and nothing of photos and lenses.
  const auto judged_views = std::ranges::count_if(seen.candidates.agreement, &labeling::ViewAgreement::judged);
  const bool photos_judged =
      seen.fit.verdict != unknown || 2 * static_cast<std::size_t>(judged_views) > input.views.size();
  // Few photos with much out of focus are a reason for doubts of photos alone; tie points that lie on the mesh dispel them.
  const bool dispelled = seen.fit.verdict == doubtful && seen.tie_point_fit.verdict == fits;
  report("fit", seen.fit, photo_fit_text(seen.fit));
  if (seen.tie_point_fit.places > 0) report("tie_points", seen.tie_point_fit, tie_point_fit_text(seen.tie_point_fit));
  if ((doubts.empty() && photos_judged) || dispelled) return;
  const std::string found = doubts.empty() ? photo_fit_text(seen.fit) : fmt::to_string(fmt::join(doubts, "; "));
  // Shares alone refuse nothing: leaves in the wind, water and a poor mesh look like that. An explanation does, and of a
  // scene that nothing is known of it is all that can tell.
  // Without a judgement a right scene of few pixels must not fall for one, which one did at 2.8 times the places.
  constexpr double kClearly = 2, kWithoutJudgement = 6;
  const std::string explanation =
      keep ? "" : fitting_hypothesis(input, photos, observer, doubts.empty() ? kWithoutJudgement : kClearly);
  if (!explanation.empty())
    throw InputError(
        input.mesh_file, "",
        found + "; the mesh is not where the photos show it: " + explanation + "; --keep-views textures all the same");
  if (doubts.empty()) return observer.note(found + " whether the mesh lies where they show it");
  observer.warning(found + (elsewhere_for_one
                                ? "; the mesh seems to be moved, scaled, turned or mirrored against the poses, or the "
                                  "lens is another: see gpvc inspect --check --picture"
                                : "; is the mesh moved, scaled or turned against the poses, or does it lack much of "
                                  "what they show?"));
}

/// Warns of photos of which no view sees a face: that a panorama's view to the sky sees none is no reason for doubt.
void report_blind(const Input& input, const std::vector<bool>& sees, Observer& observer) {
  std::map<std::string, bool> photo_sees;
  for (const ViewId id : input.views) photo_sees[io::photo_name(input.scene.views[index(id)])] |= sees[index(id)];
  std::erase_if(photo_sees, [](const auto& photo) { return photo.second; });
  if (photo_sees.empty()) return;
  const std::string& first = photo_sees.begin()->first;
  const bool one = photo_sees.size() == 1;
  observer.warning(
      one ? first + ": sees no face of the mesh: its camera may lie inside the mesh, or its pose be wrong"
          : fmt::format("{} photos see no face of the mesh, {} among them: their cameras may lie inside the mesh, or "
                        "their poses be wrong",
                        photo_sees.size(), first));
}

}  // namespace

std::launch launch_policy() {
  using Control = tbb::global_control;
  return Control::active_value(Control::max_allowed_parallelism) == 1 ? std::launch::deferred : std::launch::async;
}

std::vector<std::uint32_t> photo_of_view(const Scene& scene) {
  std::map<std::filesystem::path, std::uint32_t> first;
  std::vector<std::uint32_t> photos;
  bool shared = false;
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) {
    const std::filesystem::path& photo = scene.views[v].photo;
    photos.push_back(photo.empty() ? v : first.try_emplace(photo, v).first->second);
    shared = shared || photos.back() != v;
  }
  return shared ? photos : std::vector<std::uint32_t>();
}

std::array<std::size_t, 3> count_tags(std::span<const labeling::FaceTag> tags) {
  std::array<std::size_t, 3> counts{};
  for (const labeling::FaceTag tag : tags) ++counts[static_cast<std::size_t>(tag)];
  return counts;
}

void report_tags(const Input& input, const labeling::Candidates& candidates, Observer& observer) {
  const auto [seen, partial, unseen] = count_tags(candidates.tags);
  observer.figure("tags.seen", seen);
  observer.figure("tags.partial", partial);
  observer.figure("tags.filled", unseen);
  observer.figure("candidates.full", candidates.full);
  observer.figure("candidates.partial", candidates.partial);
  observer.figure("candidates.rejected", candidates.rejected);
  const auto percent = [&](std::size_t count) {
    return 100 * static_cast<double>(count) / static_cast<double>(candidates.tags.size());
  };
  observer.note(fmt::format("faces: {:.1f} % seen whole by some view, {:.1f} % in parts, {:.1f} % filled",
                            percent(seen), percent(partial), percent(unseen)));
  if (seen + partial == 0)
    throw InputError(input.mesh_file, "",
                     "no photo sees any face of the mesh: are mesh and cameras in the same coordinates, and the "
                     "cameras outside the mesh?");
}

Seen see(const Input& input, const Settings& settings, io::PhotoSource& photos, Observer& observer,
         const SeeOptions& options) {
  observer.begin({"visibility and costs", "views"});
  const auto device = visibility::find_device(settings.visibility, settings.device);
  if (device) observer.detail(fmt::format("device: {} ({})", device->info().renderer, device->info().driver));
  visibility::VisibilityStage visibility(input.mesh, settings.visibility, device.get());
  for (const auto& [name, text] :
       {std::pair{"drawing", visibility.drawing_note()}, {"classifier", visibility.classifier_note()}}) {
    observer.note(fmt::format("{}: {}", name, text));
    observer.figure(name, text);
  }
  labeling::CandidateCollector collector(input.mesh, settings.costs);
  const std::launch policy = launch_policy();
  Seen seen;
  if (device) seen.device = device->info();
  CoverageStore coverage;
  std::array<visibility::ViewVisibility, 2> buffers;  // one is filled while the costs of the other are computed
  std::vector<checks::SmallPhoto> small(input.scene.views.size());
  std::vector<bool> sees(input.scene.views.size(), false);
  const auto note_view = [&](ViewId id, const visibility::VisibilityStatistics& statistics) {
    seen.statistics += statistics;
    sees[index(id)] = statistics.full + statistics.partial > 0;
  };
  std::future<void> costs;  // waited for before what it uses goes, also where the run is cancelled
  // A run whose labels are kept has found the mesh right; else photos are looked at again for that.
  const bool judged = options.kept != nullptr && options.kept->selection(input.mesh.faces.size()).has_value();
  std::vector<ViewId> not_seen_again;
  const checks::TiePointFit tie_points(input, observer);
  checks::FitGroups tie_points_on_mesh{};
  for (std::size_t n = 0; n < input.views.size(); ++n) {
    observer.progress(n, input.views.size());
    const ViewId id = input.views[n];
    const View& view = input.scene.views[index(id)];
    if (options.kept != nullptr) {
      if (std::optional<ViewWork> work = options.kept->view(id)) {
        if (costs.valid()) costs.get();
        if (collector.add_statistics(id, work->statistics)) {
          note_view(id, work->visibility);
          coverage.add(std::make_shared<const PackedCoverage>(std::move(work->coverage)));
          add(work->tie_points, tie_points_on_mesh);
          if (!judged && checks::is_compared(n, input.views.size())) not_seen_again.push_back(id);
          continue;
        }
      }
      options.kept->warn_of_failure(observer);
    }
    auto decoded = std::async(policy, [&photos, id] { return photos.photo(id); });
    visibility::ViewVisibility& visible = buffers[n % 2];
    visibility.classify(view, id, photos.exclusion(id).get(), visible);
    if (options.on_view) options.on_view(id, visible);
    note_view(id, visible.statistics);
    const checks::FitGroups on_mesh = tie_points.counts(id, visible.ivm);
    add(on_mesh, tie_points_on_mesh);
    const auto packed = std::make_shared<const PackedCoverage>(pack(id, visible.coverage));
    coverage.add(packed);
    if (costs.valid()) costs.get();
    costs = std::async(policy, [&, id, packed, on_mesh, compared = checks::is_compared(n, input.views.size()),
                                photo = decoded.share()] {
      const auto pixels = photo.get();
      const auto start = Clock::now();
      if (compared) small[index(id)] = checks::small_photo(*pixels);
      collector.add_view(id, view, *pixels, visible);
      seen.costs_s += seconds_since(start);
      if (options.kept != nullptr)
        options.kept->keep_view(id, collector.statistics_of(id), *packed, visible.statistics, on_mesh);
    });
  }
  if (costs.valid()) costs.get();
  buffers = {};
  const auto start = Clock::now();
  tbb::parallel_for(std::size_t{0}, not_seen_again.size(), [&](std::size_t i) {
    small[index(not_seen_again[i])] = checks::small_photo(*photos.photo(not_seen_again[i]));
  });
  collector.set_photos(photo_of_view(input.scene));
  collector.judge(options.graph);
  if (options.on_judged) options.on_judged(collector, coverage);
  const auto allowed = allowed_views(settings.view_rules, input.mesh, input.scene.views.size(), observer);
  seen.candidates = collector.finish(options.graph, allowed);
  if (allowed) report_refused(seen.candidates.refused, observer);
  // The methods that gpvc is compared with also see faces that are hidden.
  const visibility::Method& method = settings.visibility.method;
  const bool exact =
      std::holds_alternative<visibility::Gpvc>(method) || std::holds_alternative<visibility::PaperGpvc>(method);
  if (exact && !judged) {
    seen.fit = fit_of(input, seen.candidates, small);
    seen.tie_point_fit = judge(tie_points_on_mesh);
  }
  if (!options.faces.empty()) keep_faces(options.faces, seen.candidates);
  seen.costs_s += seconds_since(start);
  seen.coverage = coverage.of_partial_faces(seen.candidates.tags);
  const visibility::VisibilityStatistics& s = seen.statistics;
  report_times(seen, observer);
  observer.figure("full", s.full);
  observer.figure("partial", s.partial);
  if (options.kept != nullptr) observer.figure("kept.views", options.kept->views_taken());
  observer.figure("hidden", input.views.size() * input.mesh.faces.size() - s.full - s.partial);
  const std::size_t taken = options.kept != nullptr ? options.kept->views_taken() : 0;
  observer.end(taken == 0 ? fmt::format("{} views", input.views.size())
                          : fmt::format("{} views, {} of them kept by an earlier run", input.views.size(), taken));
  report_tags(input, seen.candidates, observer);
  report_blind(input, sees, observer);
  report_unseen(input, settings.allow_unseen, seen.candidates.tags, small, observer);
  report_agreement(input, settings.costs.keep_views, seen.candidates.agreement, small, observer);
  if (exact && !judged) report_fits(input, settings.costs.keep_views, seen, small, observer);
  return seen;
}

}  // namespace gpvc::pipeline
