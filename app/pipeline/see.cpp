// What the views see: visibility, candidates and coverage, view after view.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <variant>

#include "app/checks/scene_fit.h"
#include "app/checks/tie_point_fit.h"
#include "app/pipeline/checkpoint.h"
#include "app/pipeline/coverage_store.h"
#include "app/pipeline/steps.h"
#include "app/pipeline/stored.h"
#include "app/pipeline/view_loop.h"
#include "app/pipeline/viewpoint.h"
#include "io/clock.h"
#include "io/error.h"
#include "io/photos.h"

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

}  // namespace

std::vector<std::uint32_t> photo_of_view(const Scene& scene) {
  std::vector<std::uint32_t> photos = io::photo_of_view(scene);
  for (std::uint32_t v = 0; v < photos.size(); ++v)
    if (photos[v] != v) return photos;
  return {};
}

void report_tags(const Input& input, const labeling::Candidates& candidates, Observer& observer) {
  const auto [seen, partial, unseen, background] = checks::count_tags(candidates.tags);
  observer.figure("tags.seen", seen);
  observer.figure("tags.partial", partial);
  observer.figure("tags.filled", unseen);
  observer.figure("tags.background", background);
  observer.figure("candidates.full", candidates.full);
  observer.figure("candidates.partial", candidates.partial);
  observer.figure("candidates.rejected", candidates.rejected);
  const auto percent = [&](std::size_t count) {
    return 100 * static_cast<double>(count) / static_cast<double>(candidates.tags.size());
  };
  observer.note(fmt::format("faces: {:.1f} % seen whole by some view, {:.1f} % in parts, {:.1f} % filled{}",
                            percent(seen), percent(partial), percent(unseen),
                            background == 0 ? "" : fmt::format(", {:.1f} % background", percent(background))));
  // Skirts of a mesh about its silhouettes are a few hundredths.
  constexpr double kManyPercent = 10;
  if (percent(background) > kManyPercent)
    observer.warning(
        fmt::format("{:.0f} % of the faces have no surface: most photos show the sky or a backdrop in their "
                    "place; they are not in the GLB",
                    percent(background)),
        {Cure::keep_background});
  if (seen + partial == 0)
    throw InputError(input.mesh_file, "",
                     "no photo sees any face of the mesh: are mesh and cameras in the same coordinates, and the "
                     "cameras outside the mesh?");
}

namespace {

// Collects what all views see.
class Sight {
 public:
  Sight(const Run& run, const SeeOptions& options)
      : run_(run),
        options_(options),
        collector_(run.input.mesh, run.settings.costs),
        look_(run.input, checks::read_tie_points(run.input.scene, run.observer), run.input.views),
        evidence_(run.input.scene.views.size()) {
    evidence_.points = look_.points();
  }

  Seen look(const OnJudged& on_judged) {
    run_.observer.begin({"see", "views"});
    Seen seen;
    seen.device = look_at_views(run_, steps());
    seen.statistics = statistics_;
    if (options_.on_looked) options_.on_looked(collector_.judging_bytes() + coverage_.bytes());
    const auto start = Clock::now();
    collector_.set_photos(photo_of_view(run_.input.scene));
    collector_.judge(options_.graph);
    if (on_judged) on_judged(collector_, coverage_);
    const auto allowed =
        allowed_views(run_.settings.view_rules, run_.input.mesh, run_.input.scene.views.size(), run_.observer);
    seen.candidates = collector_.finish(options_.graph, allowed);
    if (allowed) report_refused(seen.candidates.refused, run_.observer);
    const checks::SceneCase scene{run_.input, seen.candidates, evidence_, tolerance_of(run_.settings)};
    std::optional<checks::SceneFit> fit;
    if (!is_judged() && is_exact(run_.settings.visibility.method)) fit = checks::measure_scene(scene);
    seen.fit = fit ? fit->photos : MeshFit{};
    seen.tie_point_fit = fit ? fit->tie_points : MeshFit{};
    seen.costs_s = costs_s_ + seconds_since(start);
    report(seen);
    if (!options_.judged) checks::judge_scene(scene, fit, run_.observer);
    if (!options_.faces.empty()) keep_faces(options_.faces, seen.candidates);
    seen.coverage = coverage_.of_partial_faces(seen.candidates.tags);
    return seen;
  }

 private:
  ViewSteps steps() {
    ViewSteps steps;
    steps.up = up_direction(run_.input.scene, run_.input.views);
    if (run_.kept != nullptr) {
      steps.known = [this](ViewId id) {
        known_ = run_.kept->get<SeenView>(view_part(id));
        if (known_ && !may_be_of(id, *known_)) known_.reset();
        return known_.has_value();
      };
      steps.take = [this](ViewId id) {
        collector_.add_statistics(id, known_->statistics);
        // Seconds are those of this run.
        visibility::VisibilityStatistics& s = known_->visibility;
        for (double* seconds :
             {&s.render_s, &s.build_s, &s.upload_s, &s.readback_s, &s.classify_s, &s.shader_s, &s.claims_s})
          *seconds = 0;
        ++known_views_;
        add(id, std::move(*known_));
      };
    }
    steps.drawn = options_.on_view;
    steps.decoded = [this](ViewId id, const Image& photo, const visibility::ViewVisibility& visible) {
      const auto start = Clock::now();
      collector_.add_view(id, run_.input.scene.views[index(id)], photo, visible);
      SeenView seen{{}, pack(id, visible.coverage), visible.statistics, look_.at(id, photo, visible)};
      costs_s_ += seconds_since(start);
      if (run_.kept != nullptr) {
        seen.statistics = collector_.statistics_of(id);
        run_.kept->put(view_part(id), seen);
      }
      add(id, std::move(seen));
    };
    return steps;
  }

  // Values that no run keeps count as none, whatever the hash of their file says; nor does a view that was seen when others
  // were to be compared. Runs beside steps.decoded of the view before.
  bool may_be_of(ViewId id, const SeenView& seen) const {
    const View& view = run_.input.scene.views[index(id)];
    return seen.coverage.view == id && is_sound(seen.fit, view.camera) &&
           seen.fit.preview.image.pixels.empty() != look_.compares(id) &&
           is_sound(seen.coverage, run_.input.mesh, view) &&
           labeling::is_sound(seen.statistics, run_.input.mesh.faces.size());
  }

  void add(ViewId id, SeenView seen) {
    statistics_ += seen.visibility;
    coverage_.add(std::make_shared<const PackedCoverage>(std::move(seen.coverage)));
    evidence_.add(id, std::move(seen.fit));
  }

  // A run whose labels are kept has found the mesh right.
  bool is_judged() const { return options_.judged || kept_labels(run_).has_value(); }

  void report(const Seen& seen) const {
    Observer& observer = run_.observer;
    const std::size_t views = run_.input.views.size();
    report_times(seen, observer);
    observer.figure("full", seen.statistics.full);
    observer.figure("partial", seen.statistics.partial);
    if (run_.kept != nullptr) observer.figure("kept.views", known_views_);
    observer.figure("hidden", views * run_.input.mesh.faces.size() - seen.statistics.full - seen.statistics.partial);
    observer.end(known_views_ == 0 ? fmt::format("{} views", views)
                                   : fmt::format("{} views, {} of them kept by an earlier run", views, known_views_));
    report_tags(run_.input, seen.candidates, observer);
  }

  const Run& run_;
  const SeeOptions& options_;
  labeling::CandidateCollector collector_;
  CoverageStore coverage_;
  const checks::FitLook look_;
  checks::FitEvidence evidence_;
  visibility::VisibilityStatistics statistics_;
  std::optional<SeenView> known_;  ///< of the view that is taken next
  std::size_t known_views_ = 0;
  double costs_s_ = 0;
};

}  // namespace

bool is_exact(const visibility::Method& method) {
  return std::holds_alternative<visibility::Gpvc>(method) || std::holds_alternative<visibility::PaperGpvc>(method);
}

checks::Tolerance tolerance_of(const Settings& settings) {
  return {settings.costs.keep_odd_views, settings.allow_misfit, settings.allow_unseen};
}

std::optional<labeling::Selection> kept_labels(const Run& run) {
  if (run.kept == nullptr) return std::nullopt;
  std::optional<labeling::Selection> kept = run.kept->get<labeling::Selection>(kLabelsPart);
  const auto is_label = [&](ViewId view) { return view == kNoView || index(view) < run.input.scene.views.size(); };
  const bool fits =
      kept && kept->labels.size() == run.input.mesh.faces.size() && std::ranges::all_of(kept->labels, is_label);
  return fits ? std::move(kept) : std::nullopt;
}

Seen see(const Run& run, const SeeOptions& options) { return see(run, options, {}); }

Seen see(const Run& run, const SeeOptions& options, const OnJudged& on_judged) {
  checks::validate(run.input);
  return Sight(run, options).look(on_judged);
}

}  // namespace gpvc::pipeline
