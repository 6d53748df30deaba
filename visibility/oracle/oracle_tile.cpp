#include "visibility/oracle/oracle_tile.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace gpvc::visibility::truth {
namespace {

void add(std::uint32_t& sum, std::uint32_t more) {
  if (more != 0) std::atomic_ref(sum).fetch_add(more, std::memory_order_relaxed);
}

void mark(std::uint32_t& bits, std::uint32_t more) { std::atomic_ref(bits).fetch_or(more, std::memory_order_relaxed); }

/// Two depths closer than this may be a tie, or their order may be lost to rounding. The fourth digit covers that the
/// bound is relative to a rounded depth.
double doubtful_gap(const LocalFace::Depth& a, const LocalFace::Depth& b) {
  return a.error + b.error + 1.0001 * kTieDepth * std::abs(a.value);
}

}  // namespace

Tile::Tile(const OracleScene& scene, int column, int row)
    : scene_(scene),
      x0_(column * kSize),
      y0_(row * kSize),
      width_(std::min(kSize, scene.view.camera.width - x0_)),
      height_(std::min(kSize, scene.view.camera.height - y0_)),
      origin_x_(x0_ + kSize / 2 + 0.5),
      origin_y_(y0_ + kSize / 2 + 0.5) {}

Tile::Box Tile::box_of(std::uint32_t face) const {
  const FaceFacts& facts = scene_.facts[face];
  const auto low = [](float bound, int first) { return std::max(first, static_cast<int>(std::floor(bound))); };
  const auto high = [](float bound, int end) { return std::min(end, static_cast<int>(std::floor(bound)) + 1); };
  return {low(facts.x0, x0_), low(facts.y0, y0_), high(facts.x1, x0_ + width_), high(facts.y1, y0_ + height_)};
}

LocalFace Tile::local(std::uint32_t face) const {
  return {corners_of(scene_.mesh, scene_.vertices, face), scene_.facts[face].orientation, origin_x_, origin_y_};
}

const ExactFace& Tile::exact(std::uint32_t face) {
  const auto known = exact_.find(face);
  if (known != exact_.end()) return known->second;
  return exact_.emplace(face, ExactFace(scene_.mesh, scene_.view, face)).first->second;
}

ExactPoint Tile::centre(std::uint32_t pixel) const {
  return exact_position(x0_ + static_cast<int>(pixel % kSize) + 0.5, y0_ + static_cast<int>(pixel / kSize) + 0.5);
}

bool Tile::same_triangle(std::uint32_t f, std::uint32_t g) const {
  const auto& p = scene_.mesh.positions;
  const Triangle &a = scene_.mesh.faces[f], &b = scene_.mesh.faces[g];
  return std::all_of(a.begin(), a.end(),
                     [&](std::uint32_t v) { return p[v] == p[b[0]] || p[v] == p[b[1]] || p[v] == p[b[2]]; });
}

bool Tile::precedes(std::uint32_t f, std::uint32_t g) const {
  const bool f_front = scene_.facts[f].orientation < 0, g_front = scene_.facts[g].orientation < 0;
  return f_front != g_front ? f_front : f < g;
}

void Tile::decide_pixels(std::span<const std::uint32_t> faces, std::span<Tally> tallies) {
  nearest_.fill({std::numeric_limits<double>::infinity(), 0, kNoOwner});
  if (!scene_.view.camera.distortion.is_identity())
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x)
        outside_[static_cast<std::size_t>(y * kSize + x)] =
            !in_photo(scene_.view.camera, {x0_ + x + 0.5, y0_ + y + 0.5});
  for (const std::uint32_t face : faces) draw(face, tallies);
  resolve_claims(tallies);
  count_seen(tallies);
}

void Tile::draw(std::uint32_t face, std::span<Tally> tallies) {
  const Box box = box_of(face);
  if (box.x0 >= box.x1 || box.y0 >= box.y1) return;
  const LocalFace shape = local(face);
  std::uint32_t members = 0;
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) {
      LocalFace::Values values;
      const Answer covered = shape.covers(x + 0.5 - origin_x_, y + 0.5 - origin_y_, 0, values);
      if (covered == Answer::no) continue;
      const auto pixel = static_cast<std::uint32_t>((y - y0_) * kSize + (x - x0_));
      const LocalFace::Depth depth = shape.depth(values, 0);
      if (covered == Answer::maybe) {
        claims_.push_back({pixel, face, depth, false});
        continue;
      }
      ++members;
      if (!outside_[pixel]) compare_with_nearest(face, pixel, depth);
    }
  add(tallies[face].members, members);
}

/// A face that is certainly behind the nearest so far stays behind: a face that replaces the nearest is nearer still,
/// or claims the pixel together with it.
void Tile::compare_with_nearest(std::uint32_t face, std::size_t pixel, const LocalFace::Depth& depth) {
  Nearest& nearest = nearest_[pixel];
  if (nearest.face != kNoOwner) {
    const LocalFace::Depth best{nearest.depth, nearest.error};
    const double gap = doubtful_gap(best, depth);
    if (depth.value > best.value + gap) return;
    if (!(depth.value < best.value - gap)) {
      const auto number = static_cast<std::uint32_t>(pixel);
      claims_.push_back({number, nearest.face, best, true});
      claims_.push_back({number, face, depth, true});
      if (!(depth.value < best.value)) return;
    }
  }
  nearest = {depth.value, depth.error, face};
}

void Tile::resolve_claims(std::span<Tally> tallies) {
  std::sort(claims_.begin(), claims_.end(),
            [](const Claim& a, const Claim& b) { return a.pixel != b.pixel ? a.pixel < b.pixel : a.face < b.face; });
  const auto same = [](const Claim& a, const Claim& b) { return a.pixel == b.pixel && a.face == b.face; };
  claims_.erase(std::unique(claims_.begin(), claims_.end(), same), claims_.end());
  for (std::size_t first = 0; first < claims_.size();) {
    std::size_t next = first + 1;
    while (next < claims_.size() && claims_[next].pixel == claims_[first].pixel) ++next;
    contested_[claims_[first].pixel] = true;
    std::vector<Contender> contest = contenders({claims_.data() + first, next - first}, tallies);
    resolve_contest(claims_[first].pixel, contest, tallies);
    first = next;
  }
  claims_.clear();
}

/// The claimants that may be nearest, and the nearest face if it made no claim. Tallies the others.
std::vector<Tile::Contender> Tile::contenders(std::span<const Claim> claims, std::span<Tally> tallies) {
  const std::uint32_t pixel = claims.front().pixel;
  std::vector<Claim> all(claims.begin(), claims.end());
  const Nearest& nearest = nearest_[pixel];
  const auto is_nearest = [&](const Claim& claim) { return claim.face == nearest.face; };
  if (nearest.face != kNoOwner && std::none_of(all.begin(), all.end(), is_nearest))
    all.push_back({pixel, nearest.face, {nearest.depth, nearest.error}, true});
  const double infinity = std::numeric_limits<double>::infinity();
  LocalFace::Depth wall{outside_[pixel] ? -infinity : infinity, 0};
  for (const Claim& claim : all)
    if (claim.member && claim.depth.value + claim.depth.error < wall.value + wall.error) wall = claim.depth;
  const ExactPoint point = centre(pixel);
  std::vector<Contender> contest;
  for (const Claim& claim : all) {
    Contender contender{claim.face, claim.member, claim.member, {}};
    Tally& tally = tallies[claim.face];
    if (!claim.member) {
      const ExactFace::Coverage coverage = exact(claim.face).coverage(point);
      if (coverage.margin_px < -static_cast<long double>(kTiePx)) continue;
      contender.inside = coverage.inside;
      contender.certain = coverage.margin_px > kTiePx;
      if (contender.certain) add(tally.members, 1);
    }
    const bool behind = outside_[pixel] ||
                        (std::isfinite(wall.value) && claim.depth.value > wall.value + doubtful_gap(wall, claim.depth));
    if (!behind)
      contest.push_back(contender);
    else if (!contender.certain)
      mark(tally.on_edge, kEdgeAny | kEdgeMayMiss | (contender.inside ? kEdgeIn | kEdgeInUnseen : 0U));
  }
  return contest;
}

void Tile::resolve_contest(std::uint32_t pixel, std::vector<Contender>& contest, std::span<Tally> tallies) {
  if (contest.empty()) return;
  if (contest.size() == 1 && contest[0].certain) return add(tallies[contest[0].face].seen, 1);
  const auto twin = [&](const Contender& c) { return c.certain && same_triangle(contest[0].face, c.face); };
  if (!std::all_of(contest.begin(), contest.end(), twin)) return resolve_exactly(pixel, contest, tallies);
  // Copies of one triangle tie everywhere.
  std::uint32_t owner = contest[0].face;
  for (const Contender& c : contest) {
    add(tallies[c.face].disputed, 1);
    if (precedes(c.face, owner)) owner = c.face;
  }
  add(tallies[owner].seen_exact, 1);
}

/// First decides the contest, then tallies it. The owner is the nearest of those that cover the centre; the wall is the
/// nearest of those that cover it beyond a tie, which hides whatever lies behind it for every way of resolving ties.
void Tile::resolve_exactly(std::uint32_t pixel, std::vector<Contender>& contest, std::span<Tally> tallies) {
  const ExactPoint point = centre(pixel);
  for (Contender& c : contest) c.depth = exact(c.face).depth(point);
  const auto before = [this](const Contender& a, const Contender& b) {
    const int order = compare(a.depth, b.depth);
    return order < 0 || (order == 0 && precedes(a.face, b.face));
  };
  const Contender *wall = nullptr, *owner = nullptr;
  for (const Contender& c : contest) {
    if (!c.depth.ahead) continue;
    if (c.certain && (wall == nullptr || before(c, *wall))) wall = &c;
    if (c.inside && (owner == nullptr || before(c, *owner))) owner = &c;
  }
  for (const Contender& c : contest) count_contender(c, contest, wall, owner, tallies[c.face]);
}

void Tile::count_contender(const Contender& contender, std::span<const Contender> contest, const Contender* wall,
                           const Contender* owner, Tally& tally) {
  const auto ties_or_precedes = [](const Contender& a, const Contender& b) {
    return compare(a.depth, b.depth) <= 0 || relative_gap(a.depth, b.depth) <= kTieDepth;
  };
  const auto rival = [&](const Contender& other) {
    return &other != &contender && other.depth.ahead && ties_or_precedes(other, contender);
  };
  const bool ahead = contender.depth.ahead;
  const bool may_see = ahead && (wall == nullptr || ties_or_precedes(contender, *wall));
  const bool may_miss = !ahead || std::any_of(contest.begin(), contest.end(), rival);
  if (contender.certain) {
    if (!may_see) return;
    add(may_miss ? tally.disputed : tally.seen, 1);
    if (may_miss && &contender == owner) add(tally.seen_exact, 1);
    return;
  }
  std::uint32_t bits = kEdgeAny | (may_see ? kEdgeMaySee : 0U) | (may_miss ? kEdgeMayMiss : 0U);
  if (contender.inside) bits |= kEdgeIn | (&contender == owner ? kEdgeInSeen : kEdgeInUnseen);
  mark(tally.on_edge, bits);
}

void Tile::count_seen(std::span<Tally> tallies) const {
  for (int y = 0; y < height_; ++y) {
    std::uint32_t face = kNoOwner, count = 0;
    for (int x = 0; x < width_; ++x) {
      const auto pixel = static_cast<std::size_t>(y * kSize + x);
      const std::uint32_t here = contested_[pixel] ? kNoOwner : nearest_[pixel].face;
      if (here != face) {
        if (face != kNoOwner) add(tallies[face].seen, count);
        face = here;
        count = 0;
      }
      ++count;
    }
    if (face != kNoOwner) add(tallies[face].seen, count);
  }
}

}  // namespace gpvc::visibility::truth
