// The texels of partial charts that no view shows.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "atlas/baking/baking.h"

namespace gpvc::atlas {

/// A partial chart with texels that have no colour.
struct OpenChart {
  std::uint32_t chart = 0;
  std::vector<bool> known;  ///< per texel of partial_box(): its colour is on the page
};

/// Fills them smoothly from those around them, on the same chart and, across its border, on the charts beside it. Not all
/// pages need be open at a time: colours along borders are kept, and charts are filled in rounds, a chart as soon as it
/// or a chart beside it has a colour, so that neither the order of charts nor that of pages matters.
class PartialFiller {
 public:
  explicit PartialFiller(AtlasBuild& build);

  /// Takes over partial charts that have got their colours from photos. \pre ascending by chart
  void take_baked(std::span<PartialChart> parts);
  /// Notes that all charts of pages that another run painted are baked; `open`: those with texels without a colour.
  void take_painted(std::uint32_t first_page, std::uint32_t end_page, std::vector<OpenChart> open);
  /// The charts on a page with texels without a colour, ascending. \pre all partial charts on it are baked
  std::vector<const OpenChart*> open_on(std::uint32_t page) const;
  /// Keeps the colours that charts waiting for some have beside them on open pages. Call it when all charts with a view
  /// are baked on these pages, and after each fill().
  void look_at_borders();
  /// Chooses the charts that are filled next, the last ones with the mean of all pages. False when none is left.
  /// \pre the borders on all pages have been looked at
  bool begin_round();
  /// Fills the charts of this round that lie on open pages.
  void fill();
  /// True if charts of this round lie on the page.
  bool is_filled_now(std::uint32_t page) const { return now_[page] > 0; }
  /// True if charts that wait for colours lie on the page.
  bool is_pending(std::uint32_t page) const { return waiting_[page] > 0; }

 private:
  /// A texel's index in the chart's raster, and its colour in a layer.
  struct Seed {
    std::size_t texel;
    Color color;
  };
  /// The colours beside the places on a chart's border.
  struct Beside {
    std::vector<char> known;                       ///< per place
    std::vector<std::array<std::uint8_t, 3>> rgb;  ///< likewise
    std::vector<Color> samples;                    ///< likewise, of each layer after the first
  };

  /// Charts with all their colours wait for none, the others do.
  void note_baked(std::vector<OpenChart> charts);
  void look_beside(std::uint32_t chart);
  std::vector<Seed> border_seeds(const OpenChart& chart, std::size_t layer) const;
  void fill_chart(const OpenChart& open);
  void fill_chart(const OpenChart& open, const ChartRaster& raster, std::size_t layer);
  std::uint32_t page(std::uint32_t chart) const { return build_.places[chart].page; }

  AtlasBuild& build_;
  std::vector<std::uint32_t> unbaked_;        ///< partial charts, ascending
  std::vector<OpenChart> open_, round_;       ///< waiting, and being filled
  std::vector<Beside> beside_;                ///< per chart, in the order of its border places
  std::vector<std::uint32_t> waiting_, now_;  ///< charts per page
  bool use_mean_ = false;                     ///< in this round
  PageMean mean_;
};

}  // namespace gpvc::atlas
