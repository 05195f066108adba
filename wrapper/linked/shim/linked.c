/* The table of the Embree that this program links. CURVETRI_EMBREE is 3 or 4, set by build.rs. */
#include "embree.h"

#include "curvetri_embree.h"

/* To be called once at a time: it fills the table anew. */
const struct CurvetriEmbree *curvetri_linked_embree(void)
{
  static struct CurvetriEmbree table;
  curvetri_embree_table(&table);
  return &table;
}
