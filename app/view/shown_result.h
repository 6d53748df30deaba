// A result that is read when the page first asks for it, and what was made of it for the page.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "app/view/asking.h"
#include "app/view/result.h"
#include "app/view/server.h"

namespace gpvc::view {

/// Thread-safe.
class ShownResult {
 public:
  /// Reads it. With a scene whose mesh it shows, it is drawn in the scene's coordinates.
  ShownResult(const std::filesystem::path& folder, const ScratchFolder& scratch, std::shared_ptr<const Asking> asking);

  /// Answers "model.json", "geometry", "pages/N", "quarters/N" and "values/NAME"; status 404 for anything else.
  Reply answer(const std::string& path);
  const Result& result() const { return result_; }
  /// Per face of the scene's mesh its photo, -1: none. \pre a scene
  std::vector<std::int32_t> labels_of_mesh() const;
  std::vector<std::string> paths() const;  ///< all that answer() answers

 private:
  Reply model_json() const;
  Reply quarter(const ResultPage& page);
  Reply values(const std::string& name);

  Result result_;
  std::shared_ptr<const Asking> asking_;
  DrawnModel drawn_;
  std::shared_ptr<const std::string> geometry_;
  std::mutex quarters_;  ///< held while one is made: pages are large
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const std::string>> values_;
};

}  // namespace gpvc::view
