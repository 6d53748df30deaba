// How photos agree with each other, in files of kept work. Field by field: ViewAgreement has padding.
#pragma once

#include <span>
#include <vector>

#include "io/work_store.h"
#include "labeling/labeling.h"

namespace gpvc::pipeline {

inline void write_agreement(io::WorkStore::Writer& out, std::span<const labeling::ViewAgreement> agreement) {
  out.add(agreement.size());
  for (const labeling::ViewAgreement& each : agreement) {
    out.add(each.view);
    out.add(each.steps);
    out.add(each.correlation);
    out.add(each.chance);
    out.add(each.judged);
    out.add(each.by_chance);
  }
}

inline std::vector<labeling::ViewAgreement> read_agreement(io::WorkStore::Reader& in) {
  std::vector<labeling::ViewAgreement> agreement;
  for (auto left = in.get<std::size_t>(); left > 0; --left) {
    labeling::ViewAgreement& each = agreement.emplace_back();
    each.view = in.get<ViewId>();
    each.steps = in.get<std::size_t>();
    each.correlation = in.get<double>();
    each.chance = in.get<double>();
    each.judged = in.get<bool>();
    each.by_chance = in.get<bool>();
  }
  return agreement;
}

}  // namespace gpvc::pipeline
