#include "app/python/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "app/pipeline/options.h"
#include "app/results/observer.h"
#include "io/images.h"

namespace gpvc::python {
namespace {

using pipeline::IsNamed;
using pipeline::names_of;
using pipeline::OptionInfo;
using visibility::Method;
using Color = std::array<std::uint8_t, 3>;

// What a call leaves in an output folder for later commands is none of a module that returns its result.
bool is_offered(const OptionInfo& info) {
  const std::string_view name = info.name;
  return info.group != nullptr && name != "resume" && name != "editable";
}

std::string argument_name(const OptionInfo& info) {
  std::string name = info.name;
  std::ranges::replace(name, '-', '_');
  return name;
}

// Reads the value of an option.
struct Reader {
  py::handle given;
  std::string name;
  const OptionInfo& info;

  void operator()(Method& method) const {
    const std::string mode = text();
    try {
      method = visibility::parse_visibility_mode(mode);
    } catch (const std::invalid_argument& wrong) {
      throw py::value_error(name + ": " + wrong.what());
    }
    if (std::holds_alternative<visibility::RayTracing>(method))  // see CMakeLists.txt
      throw py::value_error(fmt::format("{}='{}': rays are traced by the program alone", name, mode));
  }
  void operator()(bool& value) const {
    const bool is_bool = py::isinstance<py::bool_>(given) || py::isinstance(given, numpy_bool());
    if (!is_bool) refuse_type("True or False");
    value = given.cast<bool>();
  }
  void operator()(Color& color) const {
    std::vector<double> channels;
    if (py::isinstance<py::sequence>(given) && !py::isinstance<py::str>(given))
      for (const py::handle channel : given) channels.push_back(whole(channel));
    const bool is_color = channels.size() == color.size() && std::ranges::all_of(channels, [&](double channel) {
                            return channel >= info.least && channel <= info.most;
                          });
    if (!is_color) throw py::value_error(fmt::format("{}: expected three numbers of 0 to 255", name));
    for (std::size_t c = 0; c < color.size(); ++c) color[c] = static_cast<std::uint8_t>(channels[c]);
  }
  template <typename Value>
  void operator()(Value& value) const {
    if constexpr (IsNamed<Value>) {
      const std::string word = text();
      const auto& names = names_of(value);
      const auto found = std::ranges::find_if(names, [&](const auto& known) { return word == known.name; });
      if (found == std::end(names))
        throw py::value_error(fmt::format("{}='{}': expected {}", name, word, words(names)));
      value = found->value;
    } else if (info.is_amount() && py::isinstance<py::str>(given)) {
      const auto bytes = results::bytes_from_text(text());
      if (!bytes)
        throw py::value_error(fmt::format("{}='{}': expected an amount such as '600M' or '4G'", name, text()));
      value = static_cast<Value>(*bytes);
    } else {
      const double number = std::integral<Value> ? whole(given) : real(given);
      const double least = info.is_amount() ? 1 : info.least, most = info.is_amount() ? 0x1p60 : info.most;
      if (!(number >= least && number <= most))
        throw py::value_error(fmt::format("{}={}: expected {} to {}", name, number, least, most));
      value = static_cast<Value>(number);
    }
  }

  template <typename Names>
  static std::string words(const Names& names) {
    std::string all;
    for (const auto& known : names) all += (all.empty() ? "'" : ", '") + std::string(known.name) + "'";
    return all;
  }

 private:
  static py::object numpy_bool() { return py::module_::import("numpy").attr("bool_"); }
  [[noreturn]] void refuse_type(const char* expected) const {
    throw py::type_error(fmt::format("{}: expected {}, got {}", name, expected,
                                     py::str(given.get_type().attr("__name__")).cast<std::string>()));
  }
  std::string text() const {
    if (!py::isinstance<py::str>(given)) refuse_type("a string");
    return given.cast<std::string>();
  }
  double whole(py::handle number) const {
    const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(number.ptr()));
    if (!index || py::isinstance<py::bool_>(number)) {
      PyErr_Clear();
      refuse_type("a whole number");
    }
    return real(index);
  }
  double real(py::handle number) const {
    const auto value = py::reinterpret_steal<py::object>(PyNumber_Float(number.ptr()));
    if (!value || py::isinstance<py::bool_>(number) || py::isinstance<py::str>(number)) {
      PyErr_Clear();
      refuse_type("a number");
    }
    return value.cast<double>();
  }
};

template <typename T>
void set_options(T& settings, const py::dict& options) {
  std::size_t taken = 0;
  pipeline::for_each_option(settings, [&](auto& value, const OptionInfo& info) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (!std::same_as<Value, std::vector<pipeline::ViewRule>>) {
      const std::string name = argument_name(info);
      if (!is_offered(info) || !options.contains(name)) return;
      Reader{options[name.c_str()], name, info}(value);
      ++taken;
    }
  });
  if (taken != options.size())
    throw std::logic_error("an option that is not in the list");  // gpvc._options looks before
}

// An option as Python describes it.
struct Describer {
  py::dict& entry;
  const OptionInfo& info;

  void operator()(const Method& method) const { put("str", py::str(visibility::visibility_mode_name(method))); }
  void operator()(bool value) const { put("bool", py::bool_(value)); }
  void operator()(const Color& color) const { put("tuple", py::make_tuple(color[0], color[1], color[2])); }
  template <typename Value>
  void operator()(const Value& value) const {
    if constexpr (IsNamed<Value>) {
      py::list choices;
      for (const auto& known : names_of(value)) choices.append(known.name);
      put("str", py::str(name_of(names_of(value), value)));
      entry["choices"] = choices;
    } else {
      const bool is_unset = static_cast<double>(value) < info.least || info.is_amount();
      put(info.is_amount()       ? "amount"
          : std::integral<Value> ? "int"
                                 : "float",
          is_unset ? py::object(py::none()) : py::object(py::cast(value)));
      entry["least"] = info.least;
      entry["most"] = info.most;
    }
  }

 private:
  void put(const char* type, const py::object& value) const {
    entry["type"] = type;
    entry["default"] = value;
  }
};

template <typename T>
py::list described() {
  py::list all;
  const T defaults{};
  pipeline::for_each_option(defaults, [&](const auto& value, const OptionInfo& info) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (!std::same_as<Value, std::vector<pipeline::ViewRule>>) {
      if (!is_offered(info)) return;
      py::dict entry;
      entry["name"] = argument_name(info);
      entry["help"] = info.help;
      entry["group"] = info.group;
      Describer{entry, info}(value);
      all.append(entry);
    }
  });
  return all;
}

}  // namespace

pipeline::Settings settings_from(const py::dict& options) {
  pipeline::Settings settings;
  set_options(settings, options);
  const pipeline::OutputSettings& output = settings.output;
  if (output.target == pipeline::Target::full && output.max_bytes > 0)
    throw py::value_error("max_bytes belongs to target='web'");
  if (output.target == pipeline::Target::web && settings.atlas.page_size > io::kMostWebpEdge)
    throw py::value_error(fmt::format("page_size={}: a WebP of target='web' has at most {} texels an edge",
                                      settings.atlas.page_size, io::kMostWebpEdge));
  return settings;
}

visibility::VisibilityOptions visibility_options_from(const py::dict& options) {
  visibility::VisibilityOptions settings;
  set_options(settings, options);
  return settings;
}

py::list texture_options() { return described<pipeline::Settings>(); }
py::list visibility_options() { return described<visibility::VisibilityOptions>(); }

}  // namespace gpvc::python
