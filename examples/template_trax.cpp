// A template matcher in C++ that speaks TraX by hand, version 3: no library but the standard one.
//
//     g++ -O2 -o template_trax template_trax.cpp
//     frameout bench frame-out --process template_cpp=./template_trax --trackers template_cpp hold --preset quick --seeds 0:2
//
// It keeps the green channel of the first box, and answers with the place of the least mean squared difference around
// its last answer. `confidence` falls with that difference.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

struct Picture {
    int width = 0, height = 0;
    std::vector<unsigned char> green;
};

static std::string unbase64(const std::string& text, size_t begin) {
    static const std::array<int, 256> value = [] {
        std::array<int, 256> made{};
        made.fill(-1);
        const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        for (size_t k = 0; k < letters.size(); ++k) made[static_cast<unsigned char>(letters[k])] = static_cast<int>(k);
        return made;
    }();
    std::string bytes;
    bytes.reserve((text.size() - begin) * 3 / 4);
    unsigned int bits = 0;
    int count = 0;
    for (size_t k = begin; k < text.size(); ++k) {
        const int next = value[static_cast<unsigned char>(text[k])];
        if (next < 0) break;
        bits = (bits << 6) | static_cast<unsigned int>(next);
        if ((count += 6) >= 8) bytes.push_back(static_cast<char>((bits >> (count -= 8)) & 0xff));
    }
    return bytes;
}

// Reads "image:WIDTH;HEIGHT;rgb;BASE64".
static bool read_picture(const std::string& text, Picture& picture) {
    int begin = 0;
    if (std::sscanf(text.c_str(), "image:%d;%d;rgb;%n", &picture.width, &picture.height, &begin) < 2 || begin == 0 ||
        picture.width < 1 || picture.height < 1)
        return false;
    const std::string rgb = unbase64(text, static_cast<size_t>(begin));
    const size_t count = static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height);
    if (rgb.size() != 3 * count) return false;
    picture.green.resize(count);
    for (size_t k = 0; k < count; ++k) picture.green[k] = static_cast<unsigned char>(rgb[3 * k + 1]);
    return true;
}

// Returns the words of a line; those in quotes may hold spaces.
static std::vector<std::string> words_of(const std::string& line) {
    std::vector<std::string> words;
    for (size_t k = 0; k < line.size();) {
        if (line[k] == ' ') { ++k; continue; }
        const char end = line[k] == '"' ? '"' : ' ';
        const size_t begin = end == '"' ? k + 1 : k;
        const size_t stop = std::min(line.find(end, begin), line.size());
        words.push_back(line.substr(begin, stop - begin));
        k = stop + 1;
    }
    return words;
}

class Template {
public:
    void start(const Picture& picture, double x, double y, double width, double height) {
        x_ = std::clamp(static_cast<int>(std::lround(x)), 0, picture.width - 1);
        y_ = std::clamp(static_cast<int>(std::lround(y)), 0, picture.height - 1);
        width_ = std::clamp(static_cast<int>(std::lround(width)), 1, picture.width - x_);
        height_ = std::clamp(static_cast<int>(std::lround(height)), 1, picture.height - y_);
        look_.clear();
        for (int row = 0; row < height_; ++row)
            for (int column = 0; column < width_; ++column) look_.push_back(at(picture, x_ + column, y_ + row));
    }

    void update(const Picture& picture) {
        const int reach = 24, left = x_, top = y_;
        double best = 1e30;
        for (int y = std::max(top - reach, 0); y <= std::min(top + reach, picture.height - height_); ++y)
            for (int x = std::max(left - reach, 0); x <= std::min(left + reach, picture.width - width_); ++x) {
                double sum = 0.0;
                for (int row = 0; row < height_ && sum < best; ++row)
                    for (int column = 0; column < width_; ++column) {
                        const double off = at(picture, x + column, y + row) - look_[static_cast<size_t>(row * width_ + column)];
                        sum += off * off;
                    }
                if (sum < best) { best = sum; x_ = x; y_ = y; }
            }
        confidence_ = std::exp(-best / (400.0 * static_cast<double>(look_.size())));
    }

    void report() const {
        std::printf("@@TRAX:state \"%d,%d,%d,%d\" \"confidence=%.4f\"\n", x_, y_, width_, height_, confidence_);
        std::fflush(stdout);
    }

private:
    static int at(const Picture& picture, int x, int y) {
        return picture.green[static_cast<size_t>(y) * static_cast<size_t>(picture.width) + static_cast<size_t>(x)];
    }

    int x_ = 0, y_ = 0, width_ = 1, height_ = 1;
    double confidence_ = 1.0;
    std::vector<int> look_;
};

int main() {
    std::printf("@@TRAX:hello \"trax.version=3\" \"trax.name=template\" \"trax.image=memory\" \"trax.region=rectangle\"\n");
    std::fflush(stdout);
    Template tracker;
    Picture picture;
    std::string line;
    while (std::getline(std::cin, line)) {
        const std::vector<std::string> words = words_of(line);
        if (words.empty() || words[0] == "@@TRAX:quit") break;
        if (words.size() < 2 || !read_picture(words[1], picture)) return 1;
        if (words[0] == "@@TRAX:initialize") {
            double x, y, width, height;
            if (words.size() < 3 || std::sscanf(words[2].c_str(), "%lf,%lf,%lf,%lf", &x, &y, &width, &height) != 4) return 1;
            tracker.start(picture, x, y, width, height);
        } else {
            tracker.update(picture);
        }
        tracker.report();
    }
    return 0;
}
