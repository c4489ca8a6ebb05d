module bw_did_you_mean
  !! The known word that a misspelt one most likely stands for.
  implicit none (type, external)
  private
  public :: closest, suggestion

contains

  pure integer function closest(word, known)
    !! Place of the nearest of the known words; 0 where none is near.
    character(*), intent(in) :: word
    character(*), intent(in) :: known(:)
    integer :: i, distance, least
    closest = 0
    least = 1 + max(1, len_trim(word)/3)
    if (len_trim(word) > 2*len(known)) return
    do i = 1, size(known)
      distance = edits(trim(word), trim(known(i)))
      if (distance < least) then
        least = distance
        closest = i
      end if
    end do
  end function closest

  pure function suggestion(word, known, before) result(text)
    !! ` (did you mean &beam?)`, or nothing.
    character(*), intent(in) :: word
    character(*), intent(in) :: known(:)
    character(*), intent(in) :: before        !! stands before the word that is suggested
    character(:), allocatable :: text
    integer :: i
    i = closest(word, known)
    text = ''
    if (i > 0) text = ' (did you mean '//before//trim(known(i))//'?)'
  end function suggestion

  pure integer function edits(a, b)
    !! Letters inserted, dropped, replaced or swapped with their neighbour on the way from a to b
    !! (optimal string alignment).
    character(*), intent(in) :: a, b
    integer :: table(0:len(a), 0:len(b)), i, j
    table(:, 0) = [(i, i=0, len(a))]
    table(0, :) = [(j, j=0, len(b))]
    do j = 1, len(b)
      do i = 1, len(a)
        table(i, j) = min(table(i - 1, j) + 1, table(i, j - 1) + 1, &
                          table(i - 1, j - 1) + merge(0, 1, a(i:i) == b(j:j)))
        if (swapped(a(:i), b(:j))) table(i, j) = min(table(i, j), table(max(i - 2, 0), max(j - 2, 0)) + 1)
      end do
    end do
    edits = table(len(a), len(b))
  end function edits

  pure logical function swapped(a, b)
    !! Do a and b end in the same two letters in opposite order?
    character(*), intent(in) :: a, b
    swapped = .false.
    if (len(a) > 1 .and. len(b) > 1) swapped = a(len(a) - 1:) == b(len(b):)//b(len(b) - 1:len(b) - 1)
  end function swapped

end module bw_did_you_mean
