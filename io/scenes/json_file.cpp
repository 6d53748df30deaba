#include "io/scenes/json_file.h"

#include "io/files/paths.h"
#include "io/files/text_scan.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

namespace {

/// Collects the root's keys until the text ends, within a value as a rule.
class RootKeys : public nlohmann::json_sax<Json> {
 public:
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(Json::number_integer_t) override { return true; }
  bool number_unsigned(Json::number_unsigned_t) override { return true; }
  bool number_float(Json::number_float_t, const std::string&) override { return true; }
  bool string(std::string&) override { return true; }
  bool binary(Json::binary_t&) override { return true; }
  bool start_object(std::size_t) override { return ++depth_ > 0; }
  bool end_object() override { return --depth_ > 0; }
  bool start_array(std::size_t) override { return ++depth_ > 1; }  // a list as the root has no keys
  bool end_array() override { return --depth_ > 0; }
  bool key(std::string& name) override {
    if (depth_ == 1) keys.insert(name);
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override { return false; }

  std::set<std::string> keys;

 private:
  int depth_ = 0;
};

}  // namespace

JsonFile::JsonFile(const fs::path& file, std::string_view text,
                   const std::function<bool(int, const std::string&)>& omit, JsonNumbers numbers)
    : file_(file), numbers_(numbers) {
  const auto keep = [&omit](int depth, Json::parse_event_t event, Json& value) {
    return event != Json::parse_event_t::key || !omit || !omit(depth, value.get_ref<const std::string&>());
  };
  try {
    root_ = Json::parse(text.begin(), text.end(), keep);
  } catch (const Json::parse_error& error) {
    fail("byte " + std::to_string(error.byte), "expected well-formed JSON");
  } catch (const Json::exception&) {
    fail("", "expected JSON with numbers that doubles can hold");
  }
}

const Json& JsonFile::member(const std::string& place, const Json& object, const char* key) const {
  const auto found = object.find(key);
  if (found == object.end()) fail(place, std::string("has no '") + key + "'");
  return *found;
}

std::optional<double> JsonFile::number_in(const Json& value) const {
  if (value.is_number()) return value.get<double>();
  if (value.is_string() && numbers_ == JsonNumbers::quoted) return number_from(value.get_ref<const std::string&>());
  return std::nullopt;
}

double JsonFile::number(const std::string& place, const Json& object, const char* key) const {
  const std::optional<double> value = number_in(member(place, object, key));
  if (!value) fail(place, std::string("expected a number as '") + key + "'");
  return *value;
}

double JsonFile::optional_number(const std::string& place, const Json& object, const char* key,
                                 double otherwise) const {
  return object.contains(key) ? number(place, object, key) : otherwise;
}

std::string JsonFile::text(const std::string& place, const Json& object, const char* key) const {
  const Json& value = member(place, object, key);
  if (!value.is_string()) fail(place, std::string("expected a text as '") + key + "'");
  return value.get<std::string>();
}

int JsonFile::side(const std::string& place, const Json& object, const char* key) const {
  const std::optional<int> side = image_side(number(place, object, key));
  if (!side) fail(place, std::string("expected a whole number of 1 to 2^24 pixels as '") + key + "'");
  return *side;
}

std::vector<double> JsonFile::numbers(const std::string& place, const Json& object, const char* key, std::size_t count,
                                      std::size_t rows) const {
  const Json& value = member(place, object, key);
  std::vector<double> out;
  const auto append = [&](const Json& list) {
    bool fits = list.is_array() && list.size() == count;
    for (std::size_t i = 0; fits && i < count; ++i) {
      const std::optional<double> number = number_in(list[i]);
      fits = number.has_value();
      if (fits) out.push_back(*number);
    }
    if (!fits)
      fail(place, "expected " + (rows > 0 ? std::to_string(rows) + " rows of " : "") + std::to_string(count) +
                      " numbers as '" + key + "'");
  };
  if (rows == 0) {
    append(value);
  } else {
    if (!value.is_array() || value.size() != rows) append(Json());
    for (const Json& row : value) append(row);
  }
  return out;
}

const Json& JsonFile::object(const std::string& place, const Json& object, const char* key) const {
  const Json& value = member(place, object, key);
  if (!value.is_object()) fail(place, std::string("expected an object as '") + key + "'");
  return value;
}

const Json& JsonFile::objects(const std::string& place, const Json& object, const char* key) const {
  const Json& list = member(place, object, key);
  if (!list.is_array()) fail(place, std::string("expected a list as '") + key + "'");
  for (std::size_t i = 0; i < list.size(); ++i)
    if (!list[i].is_object()) fail(std::string(key) + " " + std::to_string(i), "expected an object");
  return list;
}

std::set<std::string> json_root_keys(const fs::path& file) {
  const std::string extension = lower_case(file.extension().string());
  if (extension != ".json" && extension != ".sfm") return {};
  constexpr std::size_t kHead = 1u << 20;  // lists of photos' names may stand before what tells the format
  const std::string head = first_bytes(file, kHead);
  RootKeys keys;
  Json::sax_parse(head, &keys);
  return std::move(keys.keys);
}

}  // namespace gpvc::io
