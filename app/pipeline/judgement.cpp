#include "app/pipeline/judgement.h"

#include <algorithm>
#include <charconv>
#include <concepts>
#include <string>
#include <utility>

#include "app/pipeline/edit_files.h"
#include "app/pipeline/keys.h"
#include "app/pipeline/options.h"
#include "app/pipeline/steps.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

void take_statistics(const Input& input, const labeling::CandidateCollector& collector, Judgement& judgement) {
  judgement.statistics.resize(input.scene.views.size());
  for (const ViewId id : input.views) judgement.statistics[index(id)] = collector.statistics_of(id);
  judgement.agreement = collector.agreement();
}

// Reads what keys.cpp writes of an option. False: it has no such value.
template <typename Value>
bool read_option(const std::string& text, Value& value) {
  if constexpr (std::same_as<Value, bool>) {
    value = text == "true";
    return value || text == "false";
  } else if constexpr (std::is_arithmetic_v<Value>) {
    const char* end = text.data() + text.size();
    const auto [parsed, failed] = std::from_chars(text.data(), end, value);
    return failed == std::errc{} && parsed == end;
  } else {
    for (const auto& known : names_of(value))
      if (text == known.name) {
        value = known.value;
        return true;
      }
    return false;
  }
}

labeling::CostOptions costs_of(const fs::path& from, const ResultKeys& keys) {
  labeling::CostOptions costs;
  std::apply(
      [&](const auto&... option) {
        const auto read = [&](auto& value, const OptionInfo& info) {
          const auto known = std::ranges::find(keys.option_texts, info.name, &OptionText::name);
          if (known == keys.option_texts.end() || !read_option(known->text, value))
            throw InputError(from / kEditModelFile, "", std::string("has no value of ") + info.name,
                             {Cure::make_editable});
        };
        (read(option.value, option.info), ...);
      },
      options_of(costs));
  return costs;
}

// Photos of unknown bytes, which are not read to be hashed.
class UnreadPhotos final : public io::PhotoSource {
 public:
  std::shared_ptr<const Image> photo(ViewId /*view*/) override { return nullptr; }
  std::shared_ptr<const io::PhotoExclusion> exclusion(ViewId /*view*/) override { return nullptr; }
};

}  // namespace

bool Judgement::leaves_out(ViewId view) const {
  if (costs.keep_odd_views || labeling::mostly_by_chance(agreement)) return false;
  const auto each = std::ranges::find(agreement, view, &labeling::ViewAgreement::view);
  return each != agreement.end() && each->by_chance;
}

Judgement judge(const Run& run) {
  Judgement judgement;
  judgement.costs = run.settings.costs;
  judgement.rules = run.settings.view_rules;
  see(run, {}, [&](const labeling::CandidateCollector& collector, const CoverageStore&) {
    take_statistics(run.input, collector, judgement);
  });
  return judgement;
}

Judgement read_judgement(const fs::path& from, const Run& run) {
  EditModel model = read_edit_model(from);
  UnreadPhotos unread;
  ResultKeys now = result_keys({run.input, run.settings, unread, run.observer});
  now.options = model.keys.options;
  for (ViewKeys& view : now.views) {
    const auto same = std::ranges::find(model.keys.views, view.view, &ViewKeys::view);
    if (same != model.keys.views.end()) view.photo = same->photo;
  }
  if (const std::string differs = difference(model.keys, now); !differs.empty()) throw InputError(from, "", differs);
  check_edit_model(from, run.input, model, true);
  Judgement judgement;
  judgement.costs = costs_of(from, model.keys);
  labeling::CandidateCollector collector(run.input.mesh, judgement.costs);
  CoverageStore coverage;
  read_edit_views(from, run.input, model.keys, collector, coverage);
  take_statistics(run.input, collector, judgement);
  judgement.rules = std::move(model.rules);
  judgement.labels = std::move(model.labels);
  return judgement;
}

}  // namespace gpvc::pipeline
