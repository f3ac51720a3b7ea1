/* The page's own script and style, and the charting library, as bytes of the archive. */
#define EMBED(name, file)      \
  .global name##_begin;        \
  .global name##_end;          \
  name##_begin: .incbin file;  \
  name##_end: .byte 0

  .section .rodata
  EMBED(plenum_echarts, PLENUM_ECHARTS_FILE)
  EMBED(plenum_page_script, PLENUM_PAGE_SCRIPT_FILE)
  EMBED(plenum_page_style, PLENUM_PAGE_STYLE_FILE)

  .section .note.GNU-stack, "", %progbits
