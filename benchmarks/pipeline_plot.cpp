// The plot of the benchmark of the whole program. Everything is drawn several times as large as it is shown and then
// averaged, which makes lines and letters smooth.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "benchmarks/pipeline.h"
#include "io/images.h"

namespace gpvc::scaling {
namespace {

constexpr int kPanelWidth = 470, kHeight = 480;  // of the picture, in pixels
constexpr double kLarger = 4;                    // the drawing, each way
constexpr double kLeft = 70, kRight = 24, kTop = 72, kBottom = 68;

const cv::Scalar kInk(38, 38, 42), kFaint(120, 120, 128), kGrid(228, 228, 232), kPaper(255, 255, 255);

// --- what a panel shows

/// Values over the panel's x.
struct Curve {
  std::string name;
  cv::Scalar color;  // red, green, blue
  std::vector<double> y;
};

struct Panel {
  std::string title, x_name, y_name;
  std::vector<double> x;
  std::vector<Curve> stack;  // areas, each on top of those before it
  std::vector<Curve> lines, dashed_lines;
};

Panel time_panel(const std::vector<Measured>& rows, const char* title, const char* x_name,
                 const std::function<double(const Measured&)>& x) {
  Panel panel{title, x_name, "seconds", {}, {}, {}, {}};
  const auto curve = [&](const char* name, const cv::Scalar& color, const auto& value) {
    Curve c{name, color, {}};
    for (const Measured& m : rows) c.y.push_back(value(m));
    return c;
  };
  for (const Measured& m : rows) panel.x.push_back(x(m));
  panel.stack = {curve("read and start", {196, 196, 202}, [](const Measured& m) { return m.stages.other; }),
                 curve("see", {86, 140, 196}, [](const Measured& m) { return m.stages.see; }),
                 curve("choose", {240, 178, 72}, [](const Measured& m) { return m.stages.choose; }),
                 curve("bake", {104, 178, 120}, [](const Measured& m) { return m.stages.bake; }),
                 curve("write", {176, 130, 186}, [](const Measured& m) { return m.stages.write; })};
  panel.dashed_lines = {curve("floor", kInk, [](const Measured& m) { return m.floor.seconds(); })};
  return panel;
}

Panel memory_panel(const std::vector<Measured>& rows) {
  Panel panel{"Peak memory by photos", "photos", "gigabytes", {}, {}, {}, {}};
  Curve peak{"peak", {200, 80, 70}, {}};
  for (const Measured& m : rows) {
    panel.x.push_back(m.size.photos);
    peak.y.push_back(m.peak_gb);
  }
  panel.lines = {peak};
  return panel;
}

// --- drawing

/// The largest of 1, 2 and 5 times a power of ten of which `most` is at least `steps` times as large.
double tick_step(double most, int steps) {
  const double power = std::pow(10, std::floor(std::log10(most / steps)));
  for (const double factor : {5.0, 2.0})
    if (factor * power * steps <= most) return factor * power;
  return power;
}

struct Axis {
  double most = 1, step = 1;  // the axis runs from 0 to `most`
};

Axis axis_to(double largest, int steps) {
  const double most = largest > 0 ? largest : 1;
  return {1.04 * most, tick_step(most, steps)};
}

/// The largest value to leave room for. The legend takes the upper left of a panel with areas; curves stay below it.
double largest_y(const Panel& panel) {
  constexpr double kLegendWidth = 0.45, kBelowLegend = 0.55;  // shares of the panel
  const double last_x = *std::max_element(panel.x.begin(), panel.x.end());
  double most = 0;
  for (std::size_t i = 0; i < panel.x.size(); ++i) {
    const bool below = !panel.stack.empty() && panel.x[i] < kLegendWidth * last_x;
    double value = 0;
    for (const Curve& area : panel.stack) value += area.y[i];
    for (const auto* curves : {&panel.lines, &panel.dashed_lines})
      for (const Curve& line : *curves) value = std::max(value, line.y[i]);
    most = std::max(most, below ? value / kBelowLegend : value);
  }
  return most;
}

enum class Align { left, middle, right };

/// Draws one panel at `left` of the picture; positions are in the picture's pixels.
class Pen {
 public:
  Pen(cv::Mat& drawing, double left, const Axis& x, const Axis& y) : drawing_(drawing), left_(left), x_(x), y_(y) {}

  double at_x(double x) const { return kLeft + x / x_.most * (kPanelWidth - kLeft - kRight); }
  double at_y(double y) const { return kHeight - kBottom - y / y_.most * (kHeight - kTop - kBottom); }
  cv::Point point(double x, double y) const {
    return {static_cast<int>(std::lround((left_ + x) * kLarger)), static_cast<int>(std::lround(y * kLarger))};
  }
  void line(const cv::Point& a, const cv::Point& b, const cv::Scalar& color, double width) const {
    cv::line(drawing_, a, b, color, static_cast<int>(width * kLarger), cv::LINE_AA);
  }
  void text(const std::string& words, double x, double y, double size, const cv::Scalar& color, Align align) const {
    const double scale = size * kLarger / 22;  // the font's capitals are 22 high
    const int thick = static_cast<int>(std::lround(1.1 * kLarger));
    int below = 0;
    const cv::Size extent = cv::getTextSize(words, cv::FONT_HERSHEY_SIMPLEX, scale, thick, &below);
    cv::Point at = point(x, y);
    at.x -= align == Align::left ? 0 : align == Align::middle ? extent.width / 2 : extent.width;
    cv::putText(drawing_, words, at, cv::FONT_HERSHEY_SIMPLEX, scale, color, thick, cv::LINE_AA);
  }
  void area(const std::vector<cv::Point>& outline, const cv::Scalar& color) const {
    cv::fillPoly(drawing_, std::vector<std::vector<cv::Point>>{outline}, color, cv::LINE_AA);
  }
  void dot(const cv::Point& at, const cv::Scalar& color) const {
    cv::circle(drawing_, at, static_cast<int>(4.5 * kLarger), kPaper, cv::FILLED, cv::LINE_AA);
    cv::circle(drawing_, at, static_cast<int>(3.2 * kLarger), color, cv::FILLED, cv::LINE_AA);
  }
  void dashes(const cv::Point& a, const cv::Point& b, const cv::Scalar& color) const {
    const double length = std::hypot(b.x - a.x, b.y - a.y), dash = 7 * kLarger, gap = 5 * kLarger;
    const auto at = [&](double d) {
      const double t = std::min(1.0, d / length);
      return cv::Point(static_cast<int>(a.x + t * (b.x - a.x)), static_cast<int>(a.y + t * (b.y - a.y)));
    };
    for (double d = 0; d < length; d += dash + gap) line(at(d), at(d + dash), color, 2);
  }

 private:
  cv::Mat& drawing_;
  double left_;
  Axis x_, y_;
};

void draw_axes(const Pen& pen, const Panel& panel, const Axis& x, const Axis& y) {
  const double bottom = kHeight - kBottom;
  pen.text(panel.title, kLeft, 36, 14.5, kInk, Align::left);
  pen.text(panel.y_name, kLeft, 60, 10.5, kFaint, Align::left);
  pen.text(panel.x_name, pen.at_x(x.most / 2), kHeight - 20, 10.5, kFaint, Align::middle);
  for (double tick = 0; tick <= y.most; tick += y.step) {
    pen.line(pen.point(kLeft, pen.at_y(tick)), pen.point(kPanelWidth - kRight, pen.at_y(tick)), kGrid, 1);
    pen.text(fmt::format("{:g}", tick), kLeft - 10, pen.at_y(tick) + 4.5, 10.5, kFaint, Align::right);
  }
  for (double tick = 0; tick <= x.most; tick += x.step) {
    pen.line(pen.point(pen.at_x(tick), bottom), pen.point(pen.at_x(tick), bottom + 5), kFaint, 1);
    pen.text(fmt::format("{:g}", tick), pen.at_x(tick), bottom + 22, 10.5, kFaint, Align::middle);
  }
}

void draw_curves(const Pen& pen, const Panel& panel) {
  const std::size_t n = panel.x.size();
  const auto place = [&](std::size_t i, double y) { return pen.point(pen.at_x(panel.x[i]), pen.at_y(y)); };
  std::vector<double> sums(n);
  for (const Curve& area : panel.stack) {
    std::vector<cv::Point> outline;
    for (std::size_t i = 0; i < n; ++i) outline.push_back(place(i, sums[i] + area.y[i]));
    for (std::size_t i = n; i-- > 0;) outline.push_back(place(i, sums[i]));
    pen.area(outline, area.color);
    for (std::size_t i = 0; i < n; ++i) sums[i] += area.y[i];
  }
  for (std::size_t i = 0; i < n && !panel.stack.empty(); ++i) pen.dot(place(i, sums[i]), kInk);
  for (const auto* curves : {&panel.lines, &panel.dashed_lines})
    for (const Curve& curve : *curves) {
      for (std::size_t i = 1; i < n; ++i) {
        const cv::Point a = place(i - 1, curve.y[i - 1]), b = place(i, curve.y[i]);
        if (curves == &panel.lines)
          pen.line(a, b, curve.color, 2.5);
        else
          pen.dashes(a, b, curve.color);
      }
      for (std::size_t i = 0; i < n; ++i) pen.dot(place(i, curve.y[i]), curve.color);
    }
}

/// From top to bottom as the areas lie, then the lines.
void draw_legend(const Pen& pen, const Panel& panel) {
  if (panel.stack.empty()) return;
  constexpr double kRow = 23, kSample = 22;
  const double x = kLeft + 14, top = kTop + 10;
  const auto rows = static_cast<double>(panel.stack.size() + panel.dashed_lines.size());
  const auto box = [&](double x0, double y0, double x1, double y1, const cv::Scalar& color) {
    pen.area({pen.point(x0, y0), pen.point(x1, y0), pen.point(x1, y1), pen.point(x0, y1)}, color);
  };
  box(x - 6, top - 4, x + 150, top + rows * kRow + 2, kPaper);
  double y = top + kRow / 2;
  const auto named = [&](const Curve& curve) {
    pen.text(curve.name, x + kSample + 10, y + 5, 10.5, kInk, Align::left);
    y += kRow;
  };
  for (auto area = panel.stack.rbegin(); area != panel.stack.rend(); ++area) {
    box(x, y - 6, x + kSample, y + 6, area->color);
    named(*area);
  }
  for (const Curve& line : panel.dashed_lines) {
    pen.dashes(pen.point(x, y), pen.point(x + kSample, y), line.color);
    named(line);
  }
}

}  // namespace

void write_plot(const Series& series, const std::filesystem::path& file) {
  std::vector<Panel> panels;
  if (!series.by_photos.empty())
    panels.push_back(time_panel(series.by_photos, "Time by photos", "megapixels of photos",
                                [](const Measured& m) { return m.megapixels(); }));
  if (!series.by_faces.empty())
    panels.push_back(time_panel(series.by_faces, "Time by faces", "millions of faces",
                                [](const Measured& m) { return 1e-6 * static_cast<double>(m.faces); }));
  if (!series.by_photos.empty()) panels.push_back(memory_panel(series.by_photos));
  if (panels.empty()) return;
  const cv::Size size(kPanelWidth * static_cast<int>(panels.size()), kHeight);
  cv::Mat drawing(cv::Size(static_cast<int>(size.width * kLarger), static_cast<int>(size.height * kLarger)), CV_8UC3,
                  kPaper);
  for (std::size_t n = 0; n < panels.size(); ++n) {
    const Panel& panel = panels[n];
    const Axis x = axis_to(*std::max_element(panel.x.begin(), panel.x.end()), 3), y = axis_to(largest_y(panel), 4);
    const Pen pen(drawing, kPanelWidth * static_cast<double>(n), x, y);
    draw_axes(pen, panel, x, y);
    draw_legend(pen, panel);
    draw_curves(pen, panel);
  }
  cv::Mat picture;
  cv::resize(drawing, picture, size, 0, 0, cv::INTER_AREA);
  Image image{size.width, size.height, 3, {}};
  image.pixels.assign(picture.data, picture.data + picture.total() * picture.elemSize());
  io::write_image(file, image, io::ImageFormat::png, 0);
}

}  // namespace gpvc::scaling
