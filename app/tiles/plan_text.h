// A plan as others read it: plan.json for engines, a table for people, a script for Slurm.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "app/tiles/plan.h"

namespace gpvc::tiles {

/// Units in waves: those of a wave wait only for units of earlier ones.
std::vector<std::vector<const Unit*>> waves(std::span<const Unit> units);

/// plan.json: {"version": 1, "program": ..., "units": [{"name", "stage", "after", "outputs", "command", "cores",
/// "memory_mb", "seconds"}, ...]}. "JOB" in a command stands for the job's folder, to which outputs are relative.
std::string plan_text(std::span<const Unit> units, const std::string& program);

/// What the plan takes, stage by stage, as lines of text for people.
std::vector<std::string> plan_table(std::span<const Unit> units);

/// The plan as a shell script that submits it to Slurm in job arrays, one for each wave.
std::string sbatch_text(std::span<const Unit> units, const std::filesystem::path& job,
                        const std::filesystem::path& program);

}  // namespace gpvc::tiles
