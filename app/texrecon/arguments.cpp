#include "app/texrecon/arguments.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <functional>
#include <string_view>
#include <vector>

namespace gpvc::texrecon {
namespace {

struct Option {
  char letter;  ///< '\0': none
  std::string_view name;
  const char* value;  ///< what it takes, as the help names it; null: nothing
  const char* help;
  std::function<void(const std::string&)> set;
};

template <typename Number>
Number number_of(const std::string& text, const std::string& option, Number least, Number most) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value >= least && value <= most))
    throw UsageError(fmt::format("--{} takes a number from {} to {}, got '{}'", option, least, most, text));
  return value;
}

template <typename Value, std::size_t n>
Value choice_of(const std::string& text, const std::string& option, const Named<Value> (&names)[n]) {
  std::string all;
  for (const Named<Value>& each : names) {
    if (text == each.name) return each.value;
    all += (all.empty() ? "" : ", ") + std::string(each.name);
  }
  throw UsageError(fmt::format("--{} takes one of {}; got '{}'", option, all, text));
}

std::vector<Option> options_of(Arguments& a, Request& request) {
  const auto on = [](bool& flag, bool to = true) { return [&flag, to](const std::string&) { flag = to; }; };
  return {
      {'D', "data_cost_file", "FILE", "Take the costs of views for faces from this file (.spt)",
       [&](const std::string& v) { a.data_costs = v; }},
      {'L', "labeling_file", "FILE",
       "Take the views of faces from this file, PREFIX_labeling.vec of another run over the same mesh and as many "
       "views",
       [&](const std::string& v) { a.labels = v; }},
      {'d', "data_term", "area|gmi",
       "Read, and of no effect: views are judged by the area of a face in the photo and the angle that it is seen "
       "under, "
       "with --nadir_mode by how far they look straight down [gmi]",
       [&](const std::string& v) { a.data_term = choice_of(v, "data_term", kDataTermNames); }},
      {'s', "smoothness_term", "potts", "[potts]",
       [&](const std::string& v) { a.smoothness = choice_of(v, "smoothness_term", kSmoothnessTermNames); }},
      {'o', "outlier_removal", "none|gauss_damping|gauss_clamping",
       "Photos whose colour of a face differs from the others' (pedestrians): used, used less, not used [none]",
       [&](const std::string& v) { a.outliers = choice_of(v, "outlier_removal", kOutlierNames); }},
      {'t', "tone_mapping", "none|gamma", "gamma: the colours' power of 1/2.2 [none]",
       [&](const std::string& v) { a.tone_mapping = choice_of(v, "tone_mapping", kToneMappingNames); }},
      {'v', "view_selection_model", nullptr, "Also write PREFIX_view_selection.obj, with a colour for each view",
       on(a.view_selection_model)},
      {'\0', "skip_geometric_visibility_test", nullptr, "Take faces for seen that others hide",
       on(a.visibility_test, false)},
      {'\0', "skip_global_seam_leveling", nullptr,
       "Leave colours as photos have them: neither exposures nor seams are levelled, and photos are not blended",
       on(a.global_leveling, false)},
      {'\0', "skip_local_seam_leveling", nullptr, "Level seams chart by chart alone", on(a.local_leveling, false)},
      {'\0', "skip_hole_filling", nullptr,
       "Read, and of no effect: faces that no photo shows are left out, or see below", on(a.hole_filling, false)},
      {'\0', "keep_unseen_faces", nullptr, "Write faces that no photo shows, too, filled with the colours around them",
       on(a.keep_unseen)},
      {'\0', "nadir_mode", nullptr,
       "For a picture from above, of a mesh whose z points up: prefer photos that look straight down; every face is "
       "written",
       on(a.nadir)},
      {'n', "nadir_weight", "X", "Read, and of no effect [65535]",
       [&](const std::string& v) { a.nadir_weight = number_of(v, "nadir_weight", 0.0, 4294967295.0); }},
      {'\0', "write_timings", nullptr, "Also write PREFIX_timings.csv", on(a.timings)},
      {'\0', "no_intermediate_results", nullptr, "Do not write PREFIX_labeling.vec", on(a.intermediate_results, false)},
      {'\0', "num_threads", "N", "Threads to use [all]; results are the same for any number",
       [&](const std::string& v) { a.threads = number_of(v, "num_threads", -1, 4096); }},
      {'\0', "max_texture_size", "N", "Largest edge of a page, 256 to 32768 texels [8192]",
       [&](const std::string& v) { a.max_texture_size = number_of(v, "max_texture_size", 256, 32768); }},
      {'h', "help", nullptr, "Print this help and end", [&](const std::string&) { request = Request::help; }},
      {'\0', "version", nullptr, "Print the version and end", [&](const std::string&) { request = Request::version; }},
  };
}

class Parser {
 public:
  Parser(std::span<const std::string> words, std::span<const Option> options) : words_(words), options_(options) {}

  /// The words that belong to no option.
  std::vector<std::string> parse() {
    bool options_ended = false;
    while (at_ < words_.size()) {
      const std::string word = trimmed(words_[at_++]);
      if (word.empty()) continue;
      if (options_ended || word.size() < 2 || word[0] != '-')
        rest_.push_back(word);
      else if (word == "--")
        options_ended = true;
      else if (word[1] == '-')
        read_name(word);
      else
        read_letters(word);
    }
    return std::move(rest_);
  }

 private:
  static std::string trimmed(const std::string& word) {
    const char* blanks = " \t\r\n";
    const std::size_t first = word.find_first_not_of(blanks);
    return first == std::string::npos ? "" : word.substr(first, word.find_last_not_of(blanks) + 1 - first);
  }

  const Option& named(const std::string& name) const {
    const Option* found = nullptr;
    for (const Option& option : options_) {
      if (option.name == name) return option;
      if (!option.name.starts_with(name)) continue;
      if (found != nullptr) throw UsageError(fmt::format("--{} may be --{} or --{}", name, found->name, option.name));
      found = &option;
    }
    if (found == nullptr || name.empty()) throw UsageError(fmt::format("there is no option --{}", name));
    return *found;
  }

  void read_name(const std::string& word) {
    const std::size_t equals = word.find('=');
    const Option& option = named(word.substr(2, equals == std::string::npos ? equals : equals - 2));
    const std::string value = equals == std::string::npos ? "" : word.substr(equals + 1);
    if (option.value != nullptr && value.empty())
      throw UsageError(fmt::format("--{0} takes a value: --{0}={1}", option.name, option.value));
    if (option.value == nullptr && equals != std::string::npos)
      throw UsageError(fmt::format("--{} takes no value, got '{}'", option.name, value));
    option.set(value);
  }

  void read_letters(const std::string& word) {
    for (std::size_t i = 1; i < word.size(); ++i) {
      const Option* option = nullptr;
      for (const Option& each : options_)
        if (each.letter == word[i]) option = &each;
      if (option == nullptr) throw UsageError(fmt::format("there is no option -{} in {}", word[i], word));
      if (option->value == nullptr) {
        option->set("");
        continue;
      }
      std::string value = word.substr(i + 1);
      if (value.empty() && at_ < words_.size()) value = trimmed(words_[at_++]);
      if (value.empty() || (i + 1 == word.size() && value[0] == '-'))
        throw UsageError(fmt::format("-{} takes a value: -{} {}", option->letter, option->letter, option->value));
      option->set(value);
      return;
    }
  }

  std::span<const std::string> words_;
  std::span<const Option> options_;
  std::size_t at_ = 0;
  std::vector<std::string> rest_;
};

/// A help text in lines of 100 columns at most, all but the first indented.
std::string wrapped(std::string_view text, std::size_t indent) {
  std::string lines, line;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    if (!line.empty() && indent + line.size() + 1 + end > 100) {
      lines += line + "\n" + std::string(indent, ' ');
      line.clear();
    }
    line += (line.empty() ? "" : " ") + std::string(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines + line;
}

}  // namespace

Request read_arguments(std::span<const std::string> words, Arguments& arguments) {
  Request request = Request::run;
  const std::vector<Option> options = options_of(arguments, request);
  const std::vector<std::string> places = Parser(words, options).parse();
  if (request != Request::run) return request;
  if (places.size() != 3)
    throw UsageError(fmt::format("expected IN_SCENE IN_MESH OUT_PREFIX, got {} {}", places.size(),
                                 places.size() == 1 ? "argument" : "arguments"));
  arguments.scene = places[0];
  arguments.mesh = places[1];
  arguments.prefix = places[2];
  if (arguments.prefix.filename().empty())
    throw UsageError(fmt::format("OUT_PREFIX {} names a folder: expected the folder and the beginning of a file's name",
                                 arguments.prefix.string()));
  if (!arguments.labels.empty() && !arguments.data_costs.empty())
    throw UsageError("--labeling_file says which views faces take: --data_cost_file has no meaning beside it");
  return request;
}

std::string help_text() {
  constexpr std::size_t kIndent = 34;
  std::string text =
      "gpvc-texrecon: textures a mesh from calibrated photos, with the command line and the files of mvs-texturing's "
      "texrecon\n\n"
      "Usage: gpvc-texrecon [OPTION]... IN_SCENE IN_MESH OUT_PREFIX\n\n"
      "  IN_SCENE    a VisualSFM .nvm file, a folder of photos with a NAME.cam beside each, a scene of the Multi-View\n"
      "              Environment and its embedding (SCENE::EMBEDDING), or any other scene that gpvc reads\n"
      "  IN_MESH     a triangle mesh (PLY, OBJ, STL, OFF, GLB) in the cameras' coordinates\n"
      "  OUT_PREFIX  an existing folder and the beginning of the files' names\n\n";
  Arguments arguments;
  Request request{};
  for (const Option& option : options_of(arguments, request)) {
    std::string left = option.letter != '\0' ? fmt::format("  -{}, --{}", option.letter, option.name)
                                             : fmt::format("      --{}", option.name);
    if (option.value != nullptr) left += fmt::format("={}", option.value);
    left += left.size() + 2 > kIndent ? "\n" + std::string(kIndent, ' ') : std::string(kIndent - left.size(), ' ');
    text += left + wrapped(option.help, kIndent) + "\n";
  }
  return text +
         "\nWrites PREFIX.obj, PREFIX.mtl, PREFIX_material0000_map_Kd.png and so on, PREFIX_labeling.vec (per face of "
         "the mesh,\n"
         "without faces that have the same vertices as a later one, the number of its view, from 1, or 0), "
         "PREFIX.conf.\n"
         "Masks: NAME.mask.png beside a photo, or ../masks/NAME.EXT.png, black where a pixel must not be used.\n\n"
         "Exit status: 0 all files are complete; 1 bad input, bad usage or a failed run; 137 not enough memory; 130 "
         "interrupted.\n";
}

std::string conf_text(const Arguments& a) {
  const auto boolean = [](bool value) { return value ? "True" : "False"; };
  return fmt::format(
      "Input scene: \t{}\nInput mesh: \t{}\nOutput prefix: \t{}\nDatacost file: \t{}\nLabeling file: \t{}\nData term: "
      "\t{}\n"
      "Smoothness term: \t{}\nOutlier removal method: \t{}\nTone mapping: \t{}\nApply global seam leveling: \t{}\n"
      "Apply local seam leveling: \t{}\n",
      a.scene.string(), a.mesh.string(), a.prefix.string(), a.data_costs.string(), a.labels.string(),
      name_of(kDataTermNames, a.data_term), name_of(kSmoothnessTermNames, a.smoothness),
      name_of(kOutlierNames, a.outliers), name_of(kToneMappingNames, a.tone_mapping), boolean(a.global_leveling),
      boolean(a.local_leveling));
}

pipeline::Settings settings_of(const Arguments& a) {
  pipeline::Settings settings;
  // Stock texrecon textures whatever it is given, and those who call it have no way to ask again.
  settings.allow_misfit = settings.allow_unseen = true;
  settings.keep_work = pipeline::KeepWork::never;
  settings.costs.outliers = a.outliers;
  if (a.nadir) {
    settings.costs.term = labeling::DataTerm::nadir;
    settings.costs.keep_odd_views = true;  // a mesh made from heights lets photos disagree whose poses are right
  }
  if (!a.labels.empty()) {
    // No photo that was chosen before is refused now.
    settings.costs.outliers = labeling::Outliers::none;
    settings.costs.keep_odd_views = true;
  }
  if (!a.visibility_test) settings.visibility.method = visibility::Method{visibility::NoTest{}};
  settings.atlas.page_size = a.max_texture_size;
  settings.atlas.unseen = a.keep_unseen || a.nadir ? atlas::UnseenFaces::fill : atlas::UnseenFaces::drop;
  settings.atlas.seams = !a.global_leveling ? atlas::SeamLeveling::none
                         : a.local_leveling ? atlas::SeamLeveling::full
                                            : atlas::SeamLeveling::global;
  if (!a.global_leveling) settings.atlas.blend = atlas::Blending::none;
  settings.output.texture = io::ImageFormat::png;
  return settings;
}

}  // namespace gpvc::texrecon
