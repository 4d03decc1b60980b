/* What the drawing module offers: the only code that links libcairo. It is loaded when a PNG is drawn. */
#ifndef HVI_LANG_DRAW_CAIRO_BRIDGE_H
#define HVI_LANG_DRAW_CAIRO_BRIDGE_H

#ifdef __cplusplus
extern "C" {
#endif

typedef struct HviCanvas HviCanvas;

/* Lengths in pixels of a sheet, of which each has `scale` x `scale` of the image. */
typedef struct {
  HviCanvas* (*open)(int width, int height, double scale);
  void (*stroke)(HviCanvas*, const double* points, int n, const double* rgb, double width);
  void (*fill)(HviCanvas*, const double* points, int n, const double* rgb);
  void (*words)(HviCanvas*, double x, double y, const char* utf8, double size, double anchor,
                const double* rgb, int upwards);
  void (*panel)(HviCanvas*, double x, double y, double width, double height, int columns, int rows,
                const unsigned char* rgba);
  /* width * scale x height * scale pixels of four bytes; 0, or 1 where there was no memory. */
  int (*pixels)(HviCanvas*, unsigned char* rgba);
  void (*close)(HviCanvas*);
} HviCanvasFunctions;

/* The name of the only symbol, and its type. */
typedef const HviCanvasFunctions* (*HviCanvasEntry)(void);
const HviCanvasFunctions* hvi_canvas_functions(void);

#ifdef __cplusplus
}
#endif

#endif
