// Bakes all pages within a memory limit.
#include "atlas/baking/page_baker.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "atlas/baking/hole_filler.h"
#include "atlas/baking/kept_pages.h"
#include "atlas/baking/partial_filler.h"
#include "io/freed_memory.h"
#include "io/scratch_file.h"

namespace gpvc::atlas {

namespace {

/// Pages that are open together.
struct PageGroup : PageRange {
  std::vector<std::uint32_t> partial;  ///< charts on them, by rank: a part of them needs few photos
  bool kept = false;                   ///< by another run
};

/// Consecutive pages that fit `bytes` together, one page at least, all of them kept or none.
std::vector<PageGroup> page_groups(const std::vector<Page>& pages, const BakeOptions& options) {
  std::vector<PageGroup> groups;
  std::size_t left = 0;
  for (std::uint32_t p = 0; p < pages.size(); ++p) {
    const bool kept = has_page(options.kept, p);
    if (groups.empty() || pages[p].bytes() > left || groups.back().kept != kept) {
      groups.push_back({{p, p}, {}, kept});
      left = std::max(options.page_bytes, pages[p].bytes());
    }
    left -= pages[p].bytes();
    groups.back().end = p + 1;
  }
  return groups;
}

/// The partial charts on the group's pages, by rank; those of a given layout by view.
std::vector<std::uint32_t> partial_charts_on(const AtlasBuild& build, const PageGroup& group) {
  const ChartSet& set = build.set;
  std::vector<std::uint32_t> charts = partial_charts(set);
  std::erase_if(charts, [&](std::uint32_t c) { return !group.has(build.places[c].page); });
  std::ranges::stable_sort(charts, {},
                           [&](std::uint32_t c) { return std::pair(set.charts[c].rank, index(set.charts[c].view)); });
  return charts;
}

class PageBaker {
 public:
  PageBaker(AtlasBuild& build, const BakeOptions& options)
      : build_(build),
        options_(options),
        partial_(build),
        holes_(build),
        groups_(page_groups(build.pages, options)),
        finished_(build.pages.size(), 0),
        filled_(build.pages.size(), 0),
        spilled_(build.pages.size(), 0) {
    for (PageGroup& group : groups_) {
      group.partial = partial_charts_on(build, group);
      if (!group.kept) ++to_paint_;
    }
    build_.spilled_means.resize(build.pages.size());
    if (!options_.take_page) result_.pages.resize(build.pages.size());
    if (!options_.take_samples && build.painting.bands != nullptr) result_.samples.resize(build.pages.size());
  }

  BakedPages bake(const Progress& progress) {
    for (const PageGroup& group : groups_) {
      const bool is_new = paint(group, progress);
      tbb::parallel_invoke([&] { look_at(group); },
                           [&] {
                             if (is_new) keep(group);
                           });
      finish_or_spill(group);
    }
    while (partial_.begin_round()) {
      for (const PageGroup& group : groups_) {
        if (!reload(group, [&](std::uint32_t p) { return partial_.is_filled_now(p); })) continue;
        partial_.fill();
        look_at(group);
        finish_or_spill(group);
      }
    }
    if (!spills()) holes_.look_at_borders();
    holes_.solve();
    for (const PageGroup& group : groups_) {
      if (!reload(group, [&](std::uint32_t p) { return finished_[p] == 0; })) continue;
      holes_.fill();
      finish_if(group, [](std::uint32_t) { return true; });
    }
    return std::move(result_);
  }

 private:
  /// True if pages are spilled: where there are several groups. A single group stays open until all is done.
  bool spills() const { return groups_.size() > 1; }

  /// Opens the pages of a group with the texels that photos give them. False if another run had painted them.
  bool paint(const PageGroup& group, const Progress& progress) {
    if (group.kept && take_kept(group)) return false;
    if (group.kept) ++to_paint_;  // the kept file is damaged: painted again
    tbb::parallel_for(group.first, group.end, [&](std::uint32_t p) { build_.open(p); });
    bake_charts(group, progress);
    return true;
  }

  void keep(const PageGroup& group) const {
    tbb::parallel_for(group.first, group.end,
                      [&](std::uint32_t p) { keep_page(options_.kept, p, build_.pages[p], partial_.open_on(p)); });
  }

  /// Notes what other pages' charts need of the open ones.
  void look_at(const PageGroup& group) {
    partial_.look_at_borders();
    if (!spills()) return;
    holes_.look_at_borders();
    tbb::parallel_for(group.first, group.end, [&](std::uint32_t p) {
      if (!build_.pages[p].is_open()) return;
      build_.spilled_means[p] = {};
      build_.spilled_means[p].add(build_.pages[p]);
    });
  }

  bool take_kept(const PageGroup& group) {
    std::vector<OpenChart> open;
    for (std::uint32_t p = group.first; p < group.end; ++p)
      if (!take_page(options_.kept, p, build_, open)) return false;
    partial_.take_painted(group.first, group.end, std::move(open));
    result_.kept_pages += group.end - group.first;
    return true;
  }

  /// In one pass over the photos, or more where the partial charts do not fit in memory together. Plain charts are baked
  /// in the first, and blended after the last.
  void bake_charts(const PageGroup& group, const Progress& progress) {
    const std::size_t charts = group.partial.size();
    const std::size_t photo_steps = build_.blending.empty() ? kSteps : kStepsBeforeBlending;
    std::size_t end = 0;
    do {
      const std::size_t first = end;
      std::vector<PartialChart> partial = next_batch(group.partial, end);
      const PhotoOrder order = passes_++ % 2 == 0 ? PhotoOrder::descending : PhotoOrder::ascending;
      const PageRange plain = first == 0 ? PageRange{group.first, group.end} : PageRange{};
      bake_photos(build_, plain, partial, order,
                  steps(progress, charts == 0 ? 0 : first * photo_steps / charts,
                        charts == 0 ? photo_steps : (end - first) * photo_steps / charts));
      tbb::parallel_for(std::size_t{0}, partial.size(), [&](std::size_t i) { write_blended(partial[i], build_); });
      partial_.take_baked(partial);
      tbb::parallel_for(std::size_t{0}, partial.size(), [&](std::size_t i) { partial[i] = {}; });
      free_memory(partial);
      if (end < charts || to_paint_ > 1) release_freed_memory();  // of many small blocks
    } while (end < charts);
    build_.input.photos.free_buffers();
    result_.invented_color.add(
        blend_charts(build_, group, options_.batch_bytes, steps(progress, photo_steps, kSteps - photo_steps)));
    ++painted_;
  }

  /// Progress over a part of the steps of a group.
  Progress steps(const Progress& progress, std::size_t first, std::size_t count) const {
    if (!progress) return {};
    return [&progress, before = kSteps * painted_ + first, count, all = kSteps * to_paint_](std::size_t done,
                                                                                            std::size_t total) {
      progress(before + count * done / std::max<std::size_t>(total, 1), all);
    };
  }

  /// Chooses the sources of as many charts, from `end` on, as options.batch_bytes hold, one at least, and moves `end`.
  std::vector<PartialChart> next_batch(std::span<const std::uint32_t> charts, std::size_t& end) {
    std::vector<PartialChart> batch;
    std::size_t left = options_.batch_bytes;
    while (end < charts.size()) {
      // What is kept of a chart is known when its sources are chosen. Some are chosen at a time.
      const std::size_t first = end;
      for (std::size_t bytes = 0; end < charts.size(); ++end) {
        bytes += choosing_bytes(build_.set.charts[charts[end]], build_.coverage, build_.options.margin_px);
        if (bytes > left && (end > first || !batch.empty())) break;
      }
      // Few charts at a time would not keep all threads busy.
      if (!batch.empty() && (end == first || left < options_.batch_bytes / 8)) {
        end = first;
        break;
      }
      for (PartialChart& part : choose_sources(build_.input, build_.options, build_.set, build_.coverage,
                                               charts.subspan(first, end - first))) {
        left -= std::min(left, part.bytes(build_.painting.layers() - 1));
        batch.push_back(std::move(part));
      }
    }
    std::ranges::sort(batch, {}, &PartialChart::chart);
    return batch;
  }

  /// Finishes the open pages of a group whose charts wait for nothing, and spills the others.
  void finish_or_spill(const PageGroup& group) {
    if (!spills()) return;
    finish_if(group, [&](std::uint32_t p) { return !partial_.is_pending(p) && !holes_.is_pending(p); });
    if (options_.scratch_folder.empty()) return;
    if (!scratch_) scratch_.emplace(options_.scratch_folder);
    tbb::parallel_for(group.first, group.end, [&](std::uint32_t p) {
      if (build_.pages[p].is_open()) put_away(p);
    });
  }

  /// Frees a page's memory. What the run keeps of a painted page is not written again.
  void put_away(std::uint32_t p) {
    if (filled_[p] == 0 && has_page(options_.kept, p)) return build_.pages[p].drop();
    build_.pages[p].spill(*scratch_, place(p));
    spilled_[p] = 1;
  }

  /// Opens a page as it was put away.
  void bring_back(std::uint32_t p) {
    if (spilled_[p] != 0) {
      build_.open(p);
      build_.pages[p].reload(*scratch_, place(p));
      return;
    }
    std::vector<OpenChart> charts;  // which the filler has
    if (!take_page(options_.kept, p, build_, charts))
      throw OutputError(options_.scratch_folder,
                        "page " + std::to_string(p) + " of the work that this run keeps cannot be read back");
  }

  /// Opens the unfinished pages of a group for which wanted(page). False if there are none.
  template <typename Wanted>
  bool reload(const PageGroup& group, const Wanted& wanted) {
    std::vector<std::uint32_t> pages;
    for (std::uint32_t p = group.first; p < group.end; ++p)
      if (wanted(p)) pages.push_back(p);
    tbb::parallel_for(std::size_t{0}, pages.size(), [&](std::size_t i) {
      if (!build_.pages[pages[i]].is_open()) bring_back(pages[i]);
      filled_[pages[i]] = 1;
    });
    return !pages.empty();
  }

  /// Where a page is spilled to.
  std::size_t place(std::uint32_t page) const {
    std::size_t bytes = 0;
    for (std::uint32_t p = 0; p < page; ++p) bytes += build_.pages[p].spilled_bytes();
    return bytes;
  }

  template <typename Ready>
  void finish_if(const PageGroup& group, const Ready& ready) {
    tbb::parallel_for(group.first, group.end, [&](std::uint32_t p) {
      if (build_.pages[p].is_open() && ready(p)) finish(p);
    });
  }

  void finish(std::uint32_t number) {
    Page& page = build_.pages[number];
    const auto inside = std::count(page.state.begin(), page.state.end(), TexelState::chart);
    const std::size_t padded = pad_charts(page, build_.options.padding);
    {
      const std::lock_guard lock(mutex_);
      result_.page_texels += page.texels();
      result_.chart_texels += static_cast<std::size_t>(inside);
      result_.padded_texels += static_cast<std::size_t>(inside) + padded;
    }
    fill_background(page);
    finished_[number] = 1;
    FinishedPage whole = page.close();
    if (build_.painting.bands != nullptr) {
      if (options_.take_samples)
        options_.take_samples(number, std::move(whole.bands));
      else
        result_.samples[number] = std::move(whole.bands);
    }
    if (options_.take_page)
      options_.take_page(number, std::move(whole.image));
    else
      result_.pages[number] = std::move(whole.image);
  }

  static constexpr std::size_t kSteps = 100, kStepsBeforeBlending = 80;  ///< of a group's progress

  AtlasBuild& build_;
  const BakeOptions& options_;
  PartialFiller partial_;
  HoleFiller holes_;
  std::vector<PageGroup> groups_;
  std::vector<char> finished_;              ///< per page
  std::vector<char> filled_, spilled_;      ///< likewise: more than painted, in scratch_
  std::size_t to_paint_ = 0, painted_ = 0;  ///< groups
  std::size_t passes_ = 0;                  ///< over the photos, begun
  std::optional<io::ScratchFile> scratch_;  ///< made when the first page is spilled
  BakedPages result_;
  std::mutex mutex_;
};

}  // namespace

BakedPages bake_pages(AtlasBuild& build, const BakeOptions& options, const Progress& progress) {
  return PageBaker(build, options).bake(progress);
}

}  // namespace gpvc::atlas
