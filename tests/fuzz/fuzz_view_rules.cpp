#include <type_traits>
#include <variant>

#include "fuzz.h"
#include "io/view_rules.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(view_rules) {
  return reads_or_refuses([&] {
    const std::vector<io::ListedViewRule> rules = io::parse_view_rules(folder() / "rules", view(data, size));
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.faces = {{0, 1, 2}};
    if (rules.empty()) std::abort();
    for (const io::ListedViewRule& rule : rules) {
      if (rule.photos.empty() || rule.place.empty()) std::abort();
      std::visit(
          [&](const auto& region) {
            if constexpr (std::is_constructible_v<io::Region, decltype(region)>)
              if (io::faces_in(region, mesh).size() != 1) std::abort();
          },
          rule.region);
    }
  });
}

}  // namespace gpvc::fuzz
