#include "app/texrecon/view_selection.h"

#include <cmath>
#include <future>
#include <utility>

#include "app/texrecon/model_files.h"

namespace gpvc::texrecon {

void write_view_selection(PrefixedFiles& files, const Mesh& mesh, std::span<const ViewId> labels,
                          const ViewNumbers& numbers, std::span<const std::uint8_t> written) {
  // A square of 4 x 4 texels for each view, and one for none.
  constexpr int kCell = 4;
  const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(numbers.count() + 1))));
  Image page;
  page.width = page.height = kCell * columns;
  page.channels = 3;
  page.pixels.resize(pixel_index(0, page.height, page.width) * 3);
  for (int y = 0; y < page.height; ++y)
    for (int x = 0; x < page.width; ++x) {
      const int number = y / kCell * columns + x / kCell;
      // Hues a golden angle apart, so that views with near numbers differ; grey for none.
      for (int c = 0; c < 3; ++c) {
        const double hue = 2.399963 * number + 2.0943951 * c;
        page.pixels[3 * pixel_index(x, y, page.width) + static_cast<std::size_t>(c)] =
            number == 0 ? std::uint8_t{128} : static_cast<std::uint8_t>(std::lround(140 + 110 * std::cos(hue)));
      }
    }
  io::TexturedModel model;
  model.mesh = &mesh;
  for (std::size_t number = 0; number <= numbers.count(); ++number) {
    const auto column = static_cast<float>(number % static_cast<std::size_t>(columns)),
               row = static_cast<float>(number / static_cast<std::size_t>(columns));
    model.texcoords.push_back(
        {(column + 0.5f) / static_cast<float>(columns), (row + 0.5f) / static_cast<float>(columns)});
  }
  for (const ViewId label : labels) {
    const auto number = static_cast<std::uint32_t>(numbers.number(label));
    model.face_texcoords.push_back({number, number, number});
  }
  model.face_page.assign(labels.size(), 0);
  ModelFiles out(files, "_view_selection", written, {});
  std::future<void> obj = out.take_model(model);
  out.take_page(0, std::move(page));
  obj.get();
}

}  // namespace gpvc::texrecon
