// Sheets, depth, colours, PNG and SVG, each against something worked out otherwise.
#include "lang/draw/axes.hpp"
#include "lang/draw/body.hpp"
#include "lang/draw/curves.hpp"
#include "lang/draw/paint.hpp"
#include "lang/draw/png.hpp"
#include "lang/draw/raster.hpp"
#include "lang/draw/svg.hpp"

#include <gtest/gtest.h>

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace hvi::lang::draw {
namespace {

using solver::VtkCell;
using solver::VtuGrid;

/// A cube of side 1 in six tetrahedra around its diagonal (Kuhn).
VtuGrid cube() {
  VtuGrid grid;
  for (int i = 0; i < 8; ++i)
    grid.points.push_back({double(i & 1), double(i >> 1 & 1), double(i >> 2 & 1)});
  grid.cell = VtkCell::tetra;
  for (const auto& path : {std::array{1, 2, 4}, {2, 4, 1}, {4, 1, 2}})
    grid.connectivity.insert(grid.connectivity.end(), {0, path[0], path[0] + path[1], 7});
  for (const auto& path : {std::array{2, 1, 4}, {1, 4, 2}, {4, 2, 1}})
    grid.connectivity.insert(grid.connectivity.end(), {0, path[0] + path[1], path[0], 7});
  return grid;
}

TEST(Skin, OfACubeIsItsTwelveTrianglesOutward) {
  const VtuGrid grid = cube();
  const Skin skin = skin_of(grid);
  ASSERT_EQ(skin.triangles.size(), 12u);
  double volume = 0.0; // by Gauss: sum of x . n over the faces
  for (const auto& [a, b, c] : skin.triangles)
    volume += dot(grid.points[a], cross(grid.points[b], grid.points[c])) / 6.0;
  EXPECT_NEAR(volume, 1.0, 1e-15);
  EXPECT_EQ(feature_edges(skin, grid.points).size(), 12u); // not the diagonals of its sides
  for (const auto& corners : corner_normals(skin, grid.points))
    for (const Point& n : corners)
      EXPECT_NEAR(std::max({std::abs(n[0]), std::abs(n[1]), std::abs(n[2])}), 1.0, 1e-15);
}

TEST(Skin, OfAQuadraticTetrahedronIsClosed) {
  VtuGrid grid;
  grid.cell = VtkCell::quadratic_tetra;
  const std::array<Point, 4> p{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (const Point& x : p) grid.points.push_back(x);
  for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}) {
    Point middle{};
    for (int k = 0; k < 3; ++k) middle[k] = (p[a][k] + p[b][k]) / 2;
    grid.points.push_back(middle);
  }
  for (int i = 0; i < 10; ++i) grid.connectivity.push_back(i);
  const Skin skin = skin_of(grid);
  ASSERT_EQ(skin.triangles.size(), 16u);
  std::map<std::pair<int, int>, int> directed; // every edge once in each direction
  double volume = 0.0;
  for (const Triangle& t : skin.triangles) {
    for (int k = 0; k < 3; ++k) ++directed[{t[k], t[(k + 1) % 3]}];
    volume += dot(grid.points[t[0]], cross(grid.points[t[1]], grid.points[t[2]])) / 6.0;
  }
  EXPECT_NEAR(volume, 1.0 / 6.0, 1e-15);
  for (const auto& [edge, count] : directed) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ((directed.count({edge.second, edge.first})), 1u);
  }
}

/// Red, green or blue, whichever is most of a pixel; ' ': clear.
char colour_at(const Image& image, int x, int y) {
  const auto* const p = image.rgba.data() + 4 * (y * image.width + x);
  if (p[3] < 128) return ' ';
  return "rgb"[std::max_element(p, p + 3) - p];
}

// Two triangles that go through each other: which is in front changes at x = 0.5, worked out by
// hand. Sorting by centres, or drawing in any order, gets half of it wrong.
TEST(Raster, NearerSurfacesHideFartherOnesAtEveryPixel) {
  const std::vector<Point> a{{0, 0, -1}, {1, 0, 1}, {0.5, 2, 0}},
      b{{0, 0, 1}, {1, 0, -1}, {0.5, 2, 0}};
  const std::vector<Triangle> one{{0, 1, 2}};
  const std::vector<std::array<Point, 3>> up{{{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}}};
  for (const bool first : {false, true}) {
    Raster raster({}, {0, 0, 100, 100, 200}, false);
    raster.surface(one, first ? a : b, up, first ? Colour{1, 0, 0} : Colour{0, 0, 1});
    raster.surface(one, first ? b : a, up, first ? Colour{0, 0, 1} : Colour{1, 0, 0});
    const Image image = raster.image();
    EXPECT_EQ(colour_at(image, 30, 180), 'b');
    EXPECT_EQ(colour_at(image, 70, 180), 'r');
    EXPECT_EQ(colour_at(image, 5, 20), ' ');
    EXPECT_EQ(colour_at(image, 50 - 3, 110), 'b');
    EXPECT_EQ(colour_at(image, 50 + 3, 110), 'r');
  }
}

TEST(Raster, ATriangleCoversItsArea) {
  const std::vector<Point> points{{0.1, 0.2, 0}, {0.9, 0.3, 0}, {0.4, 0.95, 0}};
  Raster raster({}, {0, 0, 200, 200, 200}, false);
  raster.surface({{0, 1, 2}}, points, {{}}, Colour{0, 1, 0});
  double covered = 0.0;
  const Image image = raster.image();
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) covered += image.rgba[i] / 255.0;
  const double area = (0.8 * 0.75 - 0.1 * 0.3) / 2.0;
  EXPECT_NEAR(covered / 40000.0, area, 2e-3);
}

TEST(Raster, LinesOnASurfaceAreSeenAndThoseBehindItAreNot) {
  const std::vector<Point> points{{0, 0, 0}, {1, 0, 0.8}, {1, 1, 0.8}, {0, 1, 0}};
  Raster raster({}, {0, 0, 100, 100, 100}, false);
  raster.surface({{0, 1, 2}, {0, 2, 3}}, points, {{}, {}}, Colour{0, 0, 1});
  raster.line({0.3, 0.2, 0.24}, {0.3, 0.8, 0.24}, {1, 0, 0}, 3.0); // on it
  raster.line({0.7, 0.2, 0.2}, {0.7, 0.8, 0.2}, {0, 1, 0}, 3.0);   // behind it
  const Image image = raster.image();
  EXPECT_EQ(colour_at(image, 30, 50), 'r');
  EXPECT_EQ(colour_at(image, 70, 50), 'b');
}

TEST(ColourMaps, LightnessGrowsAndZeroIsWhite) {
  const ColourMap one(0.0, 2.0), both(-1.0, 3.0);
  double before = -1.0;
  for (int i = 0; i <= 100; ++i) {
    const Colour c = one(0.02 * i);
    const double light = 0.2126 * std::pow(c.red, 2.2) + 0.7152 * std::pow(c.green, 2.2) +
                         0.0722 * std::pow(c.blue, 2.2);
    EXPECT_GT(light, before);
    before = light;
  }
  EXPECT_NEAR(both(0.0).red, both(0.0).blue, 1e-12);
  EXPECT_GT(both(0.0).green, 0.95);
  EXPECT_GT(both(1.0).red, both(1.0).blue);
  EXPECT_GT(both(-1.0).blue, both(-1.0).red);
}

TEST(Axes, TicksAreRoundAndInside) {
  EXPECT_EQ(ticks(0.0, 1.0, 4), (std::vector<double>{0.0, 0.2, 0.4, 0.2 * 3, 0.8, 1.0}));
  for (const auto& [low, high] :
       {std::pair{0.0, 1.0}, {-3e-7, 8e-7}, {1e9, 1.1e9}, {-5.0, -4.99}}) {
    const auto found = ticks(low, high, 5);
    ASSERT_GE(found.size(), 3u);
    ASSERT_LE(found.size(), 11u);
    for (const double x : found) {
      EXPECT_GE(x, low - 1e-9 * (high - low));
      EXPECT_LE(x, high + 1e-9 * (high - low));
    }
    const auto texts = number_texts(found);
    for (std::size_t i = 1; i < texts.size(); ++i) EXPECT_NE(texts[i], texts[i - 1]);
  }
}

TEST(Axes, HaveTwoNumbersAtLeast) {
  for (int wanted = 1; wanted <= 8; ++wanted)
    for (int k = 0; k < 400; ++k) {
      const double low = -2.0 + 0.013 * k, high = low + 0.003 * (1 + k * k % 701);
      const auto found = ticks(low, high, wanted);
      ASSERT_GE(found.size(), 2u) << low << " to " << high << ", " << wanted;
      for (const double x : found) {
        ASSERT_GE(x, low - 1e-9 * (high - low));
        ASSERT_LE(x, high + 1e-9 * (high - low));
      }
    }
}

std::uint32_t number_at(const std::string& bytes, std::size_t at) {
  std::uint32_t out = 0;
  for (std::size_t i = at; i < at + 4; ++i) out = out << 8 | static_cast<unsigned char>(bytes[i]);
  return out;
}

/// The chunks of a PNG, their checksums judged.
std::vector<std::pair<std::string, std::string>> chunks(const std::string& png) {
  std::vector<std::pair<std::string, std::string>> out;
  for (std::size_t at = 8; at < png.size();) {
    const std::size_t size = number_at(png, at);
    out.emplace_back(png.substr(at + 4, 4), png.substr(at + 8, size));
    const auto* const covered = reinterpret_cast<const Bytef*>(png.data() + at + 4);
    EXPECT_EQ(number_at(png, at + 8 + size), crc32(0, covered, static_cast<uInt>(size + 4)));
    at += 12 + size;
  }
  return out;
}

/// The pixels again: inflated, and filter 2 undone.
std::vector<std::uint8_t> pixels_of(const std::string& data, int width, int height) {
  const std::size_t row = 4 * static_cast<std::size_t>(width);
  std::vector<std::uint8_t> raw((row + 1) * height), out;
  uLongf size = raw.size();
  EXPECT_EQ(uncompress(raw.data(), &size, reinterpret_cast<const Bytef*>(data.data()), data.size()),
            Z_OK);
  EXPECT_EQ(size, raw.size());
  for (int y = 0; y < height; ++y)
    for (std::size_t i = 0; i < row; ++i) {
      EXPECT_EQ(raw[y * (row + 1)], 2);
      const int above = y == 0 ? 0 : out[(y - 1) * row + i];
      out.push_back(static_cast<std::uint8_t>(raw[y * (row + 1) + 1 + i] + above));
    }
  return out;
}

Image pattern(int width, int height, int seed) {
  Image image{width, height, {}};
  for (int i = 0; i < 4 * width * height; ++i)
    image.rgba.push_back(static_cast<std::uint8_t>((i * 37 + i / 7 * seed) % 256));
  return image;
}

TEST(Png, HoldsThePixels) {
  const Image image = pattern(13, 7, 5);
  const auto parts = chunks(png_bytes(image));
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].first, "IHDR");
  EXPECT_EQ(number_at(parts[0].second, 0), 13u);
  EXPECT_EQ(pixels_of(parts[1].second, 13, 7), image.rgba);
}

TEST(Png, AnimationsHoldAllFrames) {
  const std::vector<Image> frames{pattern(5, 4, 1), pattern(5, 4, 2), pattern(5, 4, 3)};
  const auto parts = chunks(apng_bytes(
      3, [&](std::size_t i) { return frames[i]; }, 80));
  std::uint32_t number = 0;
  std::size_t frame = 0;
  for (const auto& [name, data] : parts) {
    if (name == "acTL") {
      EXPECT_EQ(number_at(data, 0), 3u);
    }
    if (name == "fcTL" || name == "fdAT") {
      EXPECT_EQ(number_at(data, 0), number++);
    }
    if (name == "IDAT") {
      EXPECT_EQ(pixels_of(data, 5, 4), frames[frame++].rgba);
    }
    if (name == "fdAT") {
      EXPECT_EQ(pixels_of(data.substr(4), 5, 4), frames[frame++].rgba);
    }
  }
  EXPECT_EQ(frame, 3u);
}

TEST(Svg, TextsAreTextsWhateverTheyAre) {
  Sheet sheet;
  sheet.words({{1, 2}, "</text><script>alert(1)</script>&amp;\"'\x01\n", 12});
  const std::string text = svg_text(sheet);
  EXPECT_EQ(text.find("<script"), std::string::npos);
  EXPECT_NE(text.find("&lt;/text&gt;&lt;script&gt;alert(1)&lt;/script&gt;&amp;amp;"),
            std::string::npos);
  EXPECT_EQ(text.find('\x01'), std::string::npos);
}

TEST(Paint, CairoPaintsFillsImagesAndWords) {
  Sheet sheet;
  sheet.width = 60, sheet.height = 40;
  sheet.marks.emplace_back(Fill{{{0, 0}, {20, 0}, {20, 20}, {0, 20}}, {1, 0, 0}});
  sheet.marks.emplace_back(Panel{{20, 0}, 20, 20, {1, 1, {0, 0, 255, 255}}});
  sheet.words({{2, 38}, "xyz <&>", 16});
  const Image image = painted(sheet, 1.0);
  ASSERT_EQ(image.width, 60);
  EXPECT_EQ(colour_at(image, 10, 10), 'r');
  EXPECT_EQ(colour_at(image, 30, 10), 'b');
  int dark = 0;
  for (int y = 22; y < 40; ++y)
    for (int x = 0; x < 60; ++x) dark += image.rgba[4 * (y * 60 + x)] < 100;
  EXPECT_GT(dark, 20);
}

TEST(Fields, OfCellsBecomeMeansAtNodesWhereThatIsAsked) {
  VtuGrid grid;
  grid.cell = VtkCell::line;
  grid.points = {{0, 0, 0}, {1, 0, 0}, {4, 0, 0}};
  grid.connectivity = {0, 1, 1, 2};
  grid.cell_data = {{"s", 1, {2.0, 6.0}}};
  EXPECT_EQ(nodal_array(grid, "s").values,
            (std::vector<double>{2.0, (2.0 * 1 + 6.0 * 3) / 4.0, 6.0}));
  EXPECT_TRUE(nodal_array(grid, "nothing").values.empty());
}

/// Two triangles of a square, stresses of 2 and 10.
solver::FieldFrame two_cells() {
  solver::FieldFrame frame;
  VtuGrid grid;
  grid.cell = VtkCell::triangle;
  grid.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  grid.connectivity = {0, 1, 2, 0, 2, 3};
  grid.cell_data = {{"s", 1, {2.0, 10.0}}};
  frame.grids.push_back({"", std::move(grid)});
  return frame;
}

// A picture of stresses has each cell in its own colour: means at nodes would end at 6 where two
// cells of 2 and 10 meet, and nowhere be 10 in a body whose cells alternate.
TEST(Body, ValuesOfCellsAreDrawnCellByCell) {
  const auto frame = two_cells();
  const Numbers numbers = numbers_of(frame.grids[0].grid, "s");
  ASSERT_TRUE(numbers.of_cells);
  const auto corners = corner_numbers(skin_of(frame.grids[0].grid), numbers);
  EXPECT_EQ(corners[0], (std::array<double, 3>{2.0, 2.0, 2.0}));
  EXPECT_EQ(corners[1], (std::array<double, 3>{10.0, 10.0, 10.0}));
  BodyPicture picture;
  picture.field = "s";
  const BodyWindow window = window_of({&frame, 1}, picture);
  EXPECT_EQ(window.least, 2.0);
  EXPECT_EQ(window.most, 10.0);
  bool said = false;
  for (const Mark& mark : body_sheet(frame, picture).marks)
    if (const auto* words = std::get_if<Words>(&mark)) said = said || words->text == "cell by cell";
  EXPECT_TRUE(said);
}

// Numbers of many digits do not run out of the sheet.
TEST(Body, TheRangeOfColoursIsOnTheSheet) {
  auto frame = two_cells();
  frame.grids[0].grid.cell_data[0].values = {-0.033512345, 5.2441e-05};
  BodyPicture picture;
  picture.field = "s";
  const Sheet sheet = body_sheet(frame, picture);
  int found = 0;
  for (const Mark& mark : sheet.marks)
    if (const auto* words = std::get_if<Words>(&mark);
        words != nullptr && words->text.find(" to ") != std::string::npos) {
      const double width = 0.6 * words->size * static_cast<double>(words->text.size());
      EXPECT_LE(words->at[0] + (1.0 - words->anchor) * width, sheet.width);
      ++found;
    }
  EXPECT_EQ(found, 1);
}

/// A long thin body in 3D: low pictures have little room for the bar.
solver::FieldFrame long_body() {
  solver::FieldFrame frame;
  VtuGrid grid;
  grid.cell = VtkCell::tetra;
  grid.points = {{0, 0, 0}, {10, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  grid.connectivity = {0, 1, 2, 3};
  grid.point_data = {{"s", 1, {-0.0009366, 0.061, 0.0, 0.0}}};
  frame.grids.push_back({"", std::move(grid)});
  return frame;
}

TEST(Body, TheRangeOfColoursStandsBelowTheBar) {
  const std::vector<solver::FieldFrame> frames{two_cells(), long_body()};
  for (const solver::FieldFrame& frame : frames)
    for (const double high : {20.0, 150.0, 700.0}) {
      BodyPicture picture;
      picture.field = "s";
      picture.highest = high;
      const Sheet sheet = body_sheet(frame, picture);
      double bar = 0.0, range = 0.0;
      for (const Mark& mark : sheet.marks) {
        if (const auto* panel = std::get_if<Panel>(&mark); panel != nullptr && panel->width == 16.0)
          bar = panel->at[1] + panel->height;
        const auto* words = std::get_if<Words>(&mark);
        if (words != nullptr && words->text.find(" to ") != std::string::npos)
          range = words->at[1] - words->size;
      }
      EXPECT_GT(bar, 90.0);
      EXPECT_GE(range, bar + 8.0) << high; // half of the bar's lowest number, and some
    }
}

// The largest number stands above the least one, and so do their colours.
TEST(Axes, BarsGrowUpward) {
  Sheet sheet;
  const ColourMap colours(0.0, 10.0);
  add_bar(sheet, colours, 5.0, 7.0, 200.0, "s");
  const auto& image = std::get<Panel>(sheet.marks.front()).image;
  const Colour top = colours(10.0 * (255.5 / 256.0));
  EXPECT_EQ(image.rgba[0], static_cast<std::uint8_t>(std::lround(255.0 * top.red)));
  EXPECT_EQ(image.rgba[1], static_cast<std::uint8_t>(std::lround(255.0 * top.green)));
  int numbers = 0;
  for (const Mark& mark : sheet.marks)
    if (const auto* words = std::get_if<Words>(&mark); words != nullptr && words->text != "s") {
      EXPECT_NEAR(words->at[1] - 4.0, 207.0 - 20.0 * std::stod(words->text), 1e-9);
      ++numbers;
    }
  EXPECT_GE(numbers, 2);
}

// By a multiple of the displacement, from where it was, which is seen, too.
TEST(Body, IsDeformedByAFactor) {
  auto frame = two_cells();
  frame.grids[0].grid.point_data = {{std::string(solver::displacement_array),
                                     3,
                                     {0.5, 0, 0, 0.5, 0, 0, 0.5, 0.25, 0, 0.5, 0, 0}}};
  BodyPicture picture;
  picture.field = "s";
  picture.deformed = 4.0;
  const BodyWindow window = window_of({&frame, 1}, picture);
  EXPECT_EQ(window.left, 0.0);
  EXPECT_EQ(window.right, 3.0);
  EXPECT_EQ(window.bottom, 0.0);
  EXPECT_EQ(window.top, 2.0);
}

// Arrows of forces have their tips where the points of the law are, moved as the body is.
TEST(Body, ForcesMoveWithTheirPoints) {
  auto frame = two_cells();
  VtuGrid points;
  points.cell = VtkCell::vertex;
  points.points = {{0.5, 0, 0}};
  points.connectivity = {0};
  points.point_data = {{std::string(solver::displacement_array), 3, {0, -0.5, 0}},
                       {std::string(solver::force_array), 3, {0, 3, 0}}};
  frame.grids.push_back({"layer", std::move(points)});
  BodyPicture picture;
  picture.field = "layer.xi";
  picture.deformed = 4.0;
  const BodyWindow window = window_of({&frame, 1}, picture);
  EXPECT_EQ(window.most, 3.0);
  EXPECT_NEAR(window.bottom, -2.0 - 0.16 * std::sqrt(2.0), 1e-12); // of the tail; the tip is at -2
  EXPECT_EQ(window.top, 1.0);
}

// A table of one row, a law at one point, two columns that do not move: no line, but to be seen.
TEST(Curves, OfOnePointAreADot) {
  const auto fills = [](const std::vector<Spot>& points) {
    std::vector<Fill> out;
    for (const Mark& mark : curves_sheet({"a", "x", "y", {{"", points}}}).marks)
      if (const auto* fill = std::get_if<Fill>(&mark)) out.push_back(*fill);
    return out;
  };
  for (const double y : {0.0, -3.0, 1e-9}) {
    const auto dots = fills({{2.0, y}, {2.0, y}});
    ASSERT_EQ(dots.size(), 1u) << y;
    const auto& corner = dots[0].outline;
    EXPECT_NEAR(0.5 * (corner[0][1] + corner[2][1]), 44.0 + 0.5 * 360.0, 1e-9); // half way up
  }
  EXPECT_EQ(fills({{2.0, 1.0}, {2.5, 1.0}}).size(), 0u);
}

// The numbers beside what is 0 throughout are no powers of ten far below any size.
TEST(Curves, OfZeroHaveAPlainScale) {
  std::vector<std::string> words;
  for (const Mark& mark : curves_sheet({"a", "x", "y", {{"", {{0, 0}, {1, 0}}}}}).marks)
    if (const auto* text = std::get_if<Words>(&mark)) words.push_back(text->text);
  EXPECT_NE(std::ranges::find(words, "1"), words.end());
  EXPECT_EQ(std::ranges::find_if(words, [](const auto& w) { return w.find('e') != w.npos; }),
            words.end());
}

// Side by side while there is room, then below; what is on them moves with them.
TEST(Sheet, StandInRows) {
  Sheet one;
  one.width = 800.0, one.height = 300.0;
  one.line({{1, 2}, {3, 4}}, black);
  one.words({{5, 6}, "a"});
  one.marks.emplace_back(Panel{{7, 8}, 9, 10, {}});
  Sheet high = one;
  high.height = 400.0;
  const Sheet all = sheets_in_rows({one, high, one});
  EXPECT_EQ(all.width, 1600.0);
  EXPECT_EQ(all.height, 700.0);
  ASSERT_EQ(all.marks.size(), 9u);
  EXPECT_EQ(std::get<Stroke>(all.marks[3]).line[1], (Spot{803, 4}));
  EXPECT_EQ(std::get<Words>(all.marks[4]).at, (Spot{805, 6}));
  EXPECT_EQ(std::get<Panel>(all.marks[8]).at, (Spot{7, 408}));
}

// Frames of a picture that moves have one size and one range of colours.
TEST(Body, FramesShareTheirWindow) {
  std::vector<solver::FieldFrame> frames{two_cells(), two_cells()};
  for (auto& p : frames[1].grids[0].grid.points) p[0] *= 3.0;
  frames[1].grids[0].grid.cell_data[0].values = {-4.0, 1.0};
  BodyPicture picture;
  picture.field = "s";
  const BodyWindow window = window_of(frames, picture);
  EXPECT_EQ(window.least, -4.0);
  EXPECT_EQ(window.most, 10.0);
  EXPECT_EQ(window.right, 3.0);
  const Sheet a = body_sheet(frames[0], picture, window),
              b = body_sheet(frames[1], picture, window);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
}

} // namespace
} // namespace hvi::lang::draw
