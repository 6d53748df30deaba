// The page, as the build bundles it (page.cmake).
#pragma once

#include <span>
#include <string_view>

namespace gpvc::view {

struct PageFile {
  std::string_view name;  ///< "index.html"
  std::string_view type;
  std::string_view content;
};

/// Empty where the page could not be bundled when the program was built.
std::span<const PageFile> page_files();

}  // namespace gpvc::view
