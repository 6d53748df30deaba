// What the server answers: results, their scene, questions about it and changes.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "app/results/observer.h"
#include "app/view/asking.h"
#include "app/view/job.h"
#include "app/view/selection.h"
#include "app/view/server.h"
#include "app/view/shown_result.h"

namespace gpvc::view {

struct NamedResult {
  std::string name;
  std::filesystem::path folder;
};

/// How the first result is made again with other rules: each of them null where it cannot be.
struct Changing {
  std::filesystem::path rules, earlier_rules;  ///< see RuleFile
  /// By the rules of a file; an empty path: without rules.
  std::function<void(const std::filesystem::path& rules, results::Observer&)> apply{};
  std::function<SceneSide()> reopened{};  ///< the scene with what the new result knows
};

struct SessionInput {
  std::vector<NamedResult> results;  ///< the first is shown; the second, where there is one, beside it
  std::filesystem::path tileset{};   ///< instead of results; empty: none
  std::vector<std::string> photos;   ///< names by number; those of the scene where there is one
  WorldPoint up{0, 0, 1};
  std::optional<SceneSide> scene{};
  std::optional<Changing> changing{};
};

/// README, "What the page asks for", lists the paths.
class Session {
 public:
  /// Reads the first result. Throws InputError, OutputError. \param tell sends an event to the pages
  Session(SessionInput input, std::function<void(const std::string& event, const std::string& data)> tell);
  ~Session();

  /// Thread-safe. Throws InputError for questions that have no answer.
  Reply answer(const Request& request);
  /// Writes all that the page needs to show the results without this program. Throws OutputError.
  void write_to(const std::filesystem::path& folder);

 private:
  Reply page_json() const;
  Reply shown(const std::string& path);
  Reply asked(const Request& request);
  Reply posted(const Request& request);
  Reply photo(std::size_t number);
  Reply tile(const std::string& path) const;
  std::shared_ptr<ShownResult> result(std::size_t number);
  std::shared_ptr<Asking> asking() const;
  void apply();

  SessionInput input_;
  std::function<void(const std::string&, const std::string&)> tell_;
  ScratchFolder scratch_;
  mutable std::mutex mutex_;
  std::shared_ptr<Asking> asking_;
  std::vector<std::shared_ptr<ShownResult>> results_;
  std::shared_ptr<const labeling::FaceGraph> graph_;
  std::set<std::string> tiles_;
  std::optional<RuleFile> rules_;
  std::unique_ptr<Job> job_;  ///< last: it ends before what it uses
};

}  // namespace gpvc::view
