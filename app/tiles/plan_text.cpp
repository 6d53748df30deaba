#include "app/tiles/plan_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "app/pipeline/memory.h"

namespace gpvc::tiles {
namespace {

using Json = nlohmann::ordered_json;

double megabytes(double bytes) { return std::ceil(bytes / 1e6); }

}  // namespace

std::vector<std::vector<const Unit*>> waves(std::span<const Unit> units) {
  std::map<std::string, std::size_t> wave_of;
  std::vector<std::vector<const Unit*>> result;
  for (const Unit& unit : units) {
    std::size_t wave = 0;
    for (const std::string& before : unit.after) wave = std::max(wave, wave_of.at(before) + 1);
    wave_of[unit.name] = wave;
    if (result.size() <= wave) result.resize(wave + 1);
    result[wave].push_back(&unit);
  }
  return result;
}

std::string plan_text(std::span<const Unit> units, const std::string& program) {
  Json list = Json::array();
  for (const Unit& unit : units)
    list.push_back({{"name", unit.name},
                    {"stage", name_of(kStageNames, unit.stage)},
                    {"after", unit.after},
                    {"outputs", {fmt::format("units/{}/done.json", unit.name)}},
                    {"command", {"gpvc", "unit", "JOB", unit.name}},
                    {"cores", unit.cores},
                    {"memory_mb", static_cast<std::int64_t>(megabytes(unit.memory_bytes))},
                    {"seconds", std::ceil(unit.seconds)}});
  return Json{{"version", 1}, {"program", program}, {"units", list}}.dump(1) + "\n";
}

std::vector<std::string> plan_table(std::span<const Unit> units) {
  std::vector<std::string> lines{fmt::format("{:8} {:>6} {:>12} {:>12} {:>10} {:>12}", "stage", "units", "memory each",
                                             "core hours", "disk", "photos read")};
  double core_hours = 0, disk = 0, photos = 0, memory = 0;
  const auto line = [&](const char* name, std::size_t count, double most, double hours, double left, double read) {
    lines.push_back(fmt::format("{:8} {:>6} {:>12} {:>12.3f} {:>10} {:>12}", name, count, results::readable_bytes(most),
                                hours, results::readable_bytes(left), results::readable_bytes(read)));
  };
  for (const Named<Stage>& stage : kStageNames) {
    std::size_t count = 0;
    double most = 0, hours = 0, left = 0, read = 0;
    for (const Unit& unit : units) {
      if (unit.stage != stage.value) continue;
      ++count;
      most = std::max(most, unit.memory_bytes);
      hours += unit.seconds / 3600;
      left += unit.disk_bytes;
      read += unit.photo_bytes;
    }
    line(std::string(stage.name).c_str(), count, most, hours, left, read);
    core_hours += hours;
    disk += left;
    photos += read;
    memory = std::max(memory, most);
  }
  line("all", units.size(), memory, core_hours, disk, photos);
  return lines;
}

std::string sbatch_text(std::span<const Unit> units, const std::filesystem::path& job,
                        const std::filesystem::path& program) {
  const auto quoted = [](const std::string& text) {
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
  };
  std::string text =
      R"(#!/bin/bash
# Submits the units of a job of gpvc to Slurm: one array for each wave of units, after the wave before it.
#   [MEMORY_FACTOR=2] bash THIS [OPTION OF sbatch...]
# Given again, it takes up what is not complete; with MEMORY_FACTOR=2 where units were out of memory.
set -euo pipefail
)";
  text += fmt::format("export GPVC={} JOB={}", quoted(program.string()), quoted(job.string()));
  text += R"(
factor=${MEMORY_FACTOR:-1}
options=("$@")
after=
mkdir -p "$JOB/slurm"

# One script for every array: a task picks its unit by its index. GPVC, JOB and UNITS come with the environment, so no
# character of a path is read by a shell. The unit gets less than the allocation, which counts the shell, too.
script='#!/bin/bash
read -ra units <<<"$UNITS"
exec "$GPVC" unit "$JOB" "${units[SLURM_ARRAY_TASK_ID]}" --memory "$((SLURM_MEM_PER_NODE - 100))M" --threads "$SLURM_CPUS_PER_TASK"'

wave() {  # CORES MEMORY_MB MINUTES UNIT...
  local cores=$1 memory=$(($2 * factor + 100)) minutes=$(($3 * factor)) unit id begun=
  shift 3
  local left=()
  for unit; do [ -e "$JOB/units/$unit/done.json" ] || left+=("$unit"); done
  # Slurm takes 1000 tasks an array unless it is told otherwise (MaxArraySize), so a wave may be several arrays.
  while [ ${#left[@]} -gt 0 ]; do
    export UNITS="${left[*]:0:1000}"
    id=$(sbatch --parsable --job-name=gpvc --array=0-$((${#left[@]} < 1000 ? ${#left[@]} - 1 : 999)) \
      --cpus-per-task="$cores" --mem="${memory}M" --time="$minutes" --open-mode=append --output="$JOB/slurm/%x-%A_%a.log" \
      ${after:+"--dependency=afterok:$after"} --kill-on-invalid-dep=yes "${options[@]}" <<<"$script")
    begun=${begun:+$begun:}${id%%;*}
    left=("${left[@]:1000}")
  done
  [ -z "$begun" ] || after=$begun
}

)";
  for (const std::vector<const Unit*>& wave : waves(units)) {
    std::string names;
    double memory = 0, seconds = 0;
    int cores = 1;
    for (const Unit* unit : wave) {
      names += " " + unit->name;
      memory = std::max(memory, unit->memory_bytes);
      seconds = std::max(seconds, unit->seconds);
      cores = std::max(cores, unit->cores);
    }
    // Other machines are slower, and their disks are busy.
    const double minutes = std::ceil(10 + 3 * seconds / 60);
    text += fmt::format("wave {} {} {}{}\n", cores, megabytes(memory), minutes, names);
  }
  return text + "echo \"${after:-all units are complete}\"\n";
}

}  // namespace gpvc::tiles
